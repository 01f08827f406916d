"""Figures of segmentation, drawn from tables."""
