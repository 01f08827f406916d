"""Figures of evaluation: drawing alone, from tables that others have computed."""
