"""Benchmarks: measured comparisons with other programs, and costs of our own."""
