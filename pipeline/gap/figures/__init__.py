"""Figures of gap: drawing alone, from tables that others have computed."""
