"""Segmentation of recordings in files, and its scores."""
