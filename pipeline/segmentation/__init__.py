"""Segmentation on files: figures of contacts found and missed."""
