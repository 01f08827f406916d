"""Figures of exam: drawing alone, from tables that others have computed."""
