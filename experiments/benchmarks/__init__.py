"""Benchmarks: measured comparisons with other programs, and costs of our own."""

from rallygap.pipeline.runtime.determinism import hold_arithmetic

hold_arithmetic()  # before numpy is loaded
