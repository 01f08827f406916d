"""The blind exam on files: running it, its records and its tables."""
