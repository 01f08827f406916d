"""What shots say of the balls to come is their noise, and their spins about their course."""

import numpy as np
import pytest

from pipeline.gap.expected_balls import expected_balls
from tests.models.gap.hidden import NOMINAL, measured


def test_noise_and_spins_are_those_of_the_shots():
    """Shots from both ends; spins about x are topspin from one and backspin from the other."""
    found = expected_balls(measured(count=60, noise=0.004), NOMINAL)
    assert found.noise == pytest.approx(0.004, rel=0.1)
    # Uniform between plus and minus 250, 80 and 120 rad/s about x, y and z.
    assert np.array(found.spin) == pytest.approx([0.0, 0.0, 0.0], abs=80.0)
    left = found.spin_spread[1]
    assert left == pytest.approx(1.4826 * 125.0, rel=0.3)
    assert max(found.spin_spread) == left
