"""Measured balls: one adapter a data set, all ending in the same tables."""
