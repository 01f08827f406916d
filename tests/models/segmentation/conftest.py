"""What the tests of segmentation share."""

import numpy as np
import pytest

from tests.models.segmentation.rallies import simulated_rally


@pytest.fixture
def rally():
    return simulated_rally(np.random.default_rng(7))
