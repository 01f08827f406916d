"""What every stage shares: parameters, data contracts, sources, artefacts, tracking, figures."""

from pipeline.processor import hold_arithmetic

hold_arithmetic()
