"""Figures of sources: drawing alone, from tables that others have computed."""
