"""Segmentation of recordings in files, and its report."""
