"""Shot quality on files: the forest, and tables of the returns."""
