"""Figures of segmentation: drawing alone, from tables that others have computed."""
