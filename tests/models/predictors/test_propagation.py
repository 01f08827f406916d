"""Uncertain states spread as many balls of that distribution do."""

import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.predictors.propagation import propagated
from tests.models.predictors.balls import TRUTH

STATE = np.array([0.1, 1.2, 0.35, 0.3, -6.0, 1.0, -150.0, 20.0, 30.0])
SPREAD = np.diag(np.repeat([0.002, 0.1, 20.0], 3) ** 2)
AHEAD = np.array([0.1, 0.2, 0.3, 0.6])  # the last one after a bounce


def test_covariances_are_those_of_many_balls():
    balls = np.random.default_rng(0).multivariate_normal(STATE, SPREAD, 2000)
    flown = TRUTH.fly(balls, AHEAD).states
    _, found = propagated(TRUTH, STATE[None], SPREAD[None], AHEAD)
    _, none = propagated(TRUTH, STATE[None], 0 * SPREAD[None], AHEAD)
    for k in range(len(AHEAD)):
        size = np.sqrt(np.diag(np.cov(flown[:, k].T)))
        assert np.sqrt(np.diag((found - none)[0, k])) == pytest.approx(size, rel=0.1, abs=1e-3)


def test_process_noise_grows_as_the_filters_does():
    """In a vacuum, as the sum of the ticks' noise carried on at constant velocity."""
    vacuum = Simulator.from_dict({"gravity": {"g": 9.81}})
    _, found = propagated(vacuum, STATE[None], 0 * SPREAD[None], np.array([0.3]))
    ticks, lever = 60, 0.005 * (np.arange(60) + 0.5)
    assert found[0, 0, 3, 3] == pytest.approx(ticks * (2.0 * 0.005) ** 2)
    assert found[0, 0, 0, 0] == pytest.approx(((2.0 * 0.005 * lever) ** 2).sum(), rel=1e-3)
    assert found[0, 0, 6, 6] == pytest.approx(ticks)
