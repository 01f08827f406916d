"""Every figure, table and printed number of the paper, beside what this repository finds."""
