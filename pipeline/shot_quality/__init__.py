"""Shot quality: tables of the returns, and validation of the forest."""
