"""Tests run with the arithmetic of the stages."""

import pipeline  # noqa: F401  before numpy
