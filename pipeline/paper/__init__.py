"""Every figure, table and printed number of the paper, compared with this repository's."""
