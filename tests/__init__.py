"""Tests run with the arithmetic of the stages."""

from rallygap.pipeline.runtime.determinism import hold_arithmetic

hold_arithmetic()  # before numpy is loaded
