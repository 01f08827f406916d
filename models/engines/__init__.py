"""Whatever flies balls: our simulators, scenes of other engines, and functions."""
