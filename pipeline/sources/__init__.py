"""Recordings of every source, read by one adapter per format into the same tables."""
