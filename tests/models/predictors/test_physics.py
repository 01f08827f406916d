"""The physics predictor: exact with the true simulator, robust to outliers and lost samples."""

import numpy as np
import pytest
from scipy.interpolate import interp1d

from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import HISTORY_TIMES, History
from tests.models.predictors.balls import FIRST, TRUTH, observed

TRUE_PHYSICS = PhysicsPredictor(TRUTH)

# Balls that bounce between 8 and 56 ms after their first measurement, from tick 2 to tick 11.
BOUNCING = np.tile(FIRST[1], (7, 1))
BOUNCING[:, 2] = np.linspace(0.04, 0.16, 7)


def position_error(forecast, future, at):
    return np.linalg.norm(forecast.states[:, at, :3] - future[:, at, :3], axis=1)


def degraded(history, offsets, lost):
    """Histories with outliers, ``offsets`` by place, and straight lines where samples were lost."""
    states = history.states.copy()
    for where, offset in offsets.items():
        states[:, where, :3] += offset
    kept = np.setdiff1d(np.arange(12), lost)
    bridged = interp1d(kept, states[:, kept], axis=1)(np.arange(12))
    return History(bridged, history.mask)


def test_true_physics_on_clean_measurements_forecasts_to_a_millimetre():
    history, future = observed()
    forecast = TRUE_PHYSICS.predict(history)
    assert position_error(forecast, future, -1).max() < 1e-3
    assert np.abs(forecast.states[..., 6:] - future[..., 6:]).max() < 2.0


def test_two_outliers_and_a_lost_measurement_at_the_end_are_no_new_ball():
    """A history like one of the arena that once threw the forecast off by metres."""
    history, future = observed(noise=0.003)
    ending = degraded(history, {10: [0.05, 0.0, -0.2], 11: [-0.1, 0.0, 0.14]}, lost=[9])
    clean = position_error(TRUE_PHYSICS.predict(history), future, -1)
    assert (position_error(TRUE_PHYSICS.predict(ending), future, -1) < 3 * clean + 0.03).all()


@pytest.mark.parametrize("where", [0, 1, 2, 7, 11])
def test_an_outlier_does_not_bend_the_forecast(where):
    history, future = observed(noise=0.001)
    spoilt = degraded(history, {where: [0.1, 0.05, -0.08]}, lost=[])
    clean = position_error(TRUE_PHYSICS.predict(history), future, -1)
    assert (position_error(TRUE_PHYSICS.predict(spoilt), future, -1) < clean + 0.03).all()


@pytest.mark.parametrize("neighbours", [[-1, 1], [-2, -1], [1, 2]], ids=str)
@pytest.mark.parametrize("where", range(12))
def test_values_interpolated_towards_an_outlier(where, neighbours):
    lost = [place for place in np.add(where, neighbours) if 0 < place < 11]
    history, future = observed(np.vstack([FIRST, BOUNCING]), noise=0.003, seed=where)
    offsets = np.random.default_rng(where).normal(size=(len(history), 3))
    offsets *= 0.25 / np.linalg.norm(offsets, axis=1, keepdims=True)
    interpolated = degraded(history, {where: offsets}, lost)
    clean = position_error(TRUE_PHYSICS.predict(history), future, -1)
    assert (position_error(TRUE_PHYSICS.predict(interpolated), future, -1) < 3 * clean + 0.1).all()


@pytest.mark.parametrize("struck_at", [2, 5, 7])
def test_a_ball_struck_inside_the_history_is_found_again(struck_at):
    history, future = observed(noise=0.001)
    before = HISTORY_TIMES[:struck_at] - HISTORY_TIMES[struck_at]
    states = history.states.copy()
    states[:, :struck_at, :3] -= before[:, None] * np.array([0.0, 16.0, -2.0])
    struck = History(states, history.mask)
    assert (position_error(TRUE_PHYSICS.predict(struck), future, -1) < 0.15).all()
