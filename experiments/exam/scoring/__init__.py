"""Scores: from exam records to marks, rates and the removable gap, the same for every method."""
