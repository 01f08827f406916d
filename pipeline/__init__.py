"""What every stage shares: parameters, data contracts, sources, artefacts, tracking, figures."""

from pipeline.runtime.determinism import hold_arithmetic

hold_arithmetic()
