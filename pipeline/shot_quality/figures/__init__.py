"""Figures of shot quality: drawing alone, from tables that others have computed."""
