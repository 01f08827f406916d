"""Shot quality: tables of the returns, validation of the forest, and the report."""
