"""Forecasts beyond 300 ms: simulators fly on, learned predictors continue their own forecasts."""

import numpy as np
import pytest

from rallygap.models.predictors.long_forecast import forecast_at
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import FUTURE_TIMES, HISTORY_TIMES, Forecast, History
from tests.models.predictors.balls import TRUTH, observed

LAUNCH = np.array([[0.1, 1.2, 0.3], [0.0, 1.0, 0.2]])
VELOCITY = np.array([[0.2, -6.0, 1.0], [-0.3, -4.0, 0.5]])
SPIN = np.array([[10.0, 20.0, 30.0], [0.0, -50.0, 0.0]])


class Straight:
    """A predictor that continues the line through the last two positions, and the last spin."""

    def __init__(self, labelled):
        self.labelled = labelled

    def predict(self, history):
        assert history.mask[..., :3].all()
        assert (history.mask[..., 3:] == self.labelled).all()
        place, spin = history.states[:, -1, :3], history.states[:, -1, 3:]
        velocity = (place - history.states[:, -2, :3]) / 0.005
        moved = place[:, None] + FUTURE_TIMES[:, None] * velocity[:, None]
        rest = np.concatenate([velocity, spin], axis=1)[:, None].repeat(60, axis=1)
        return Forecast(np.concatenate([moved, rest], axis=2), history.spin_measured)


def thrown(labelled):
    """Histories of balls on straight lines."""
    places = LAUNCH[:, None] + HISTORY_TIMES[:, None] * VELOCITY[:, None]
    states = np.concatenate([places, SPIN[:, None].repeat(12, axis=1)], axis=2)
    mask = np.ones(states.shape, dtype=bool)
    mask[..., 3:] = labelled
    return History(np.where(mask, states, 0.0), mask)


@pytest.mark.parametrize("labelled", [True, False])
def test_a_forecast_that_is_right_goes_on_right_with_labels_if_there_were_any(labelled):
    ahead = np.array([[0.004, 0.0125, 0.3, 0.3025, 0.9, 1.4], [0.0, 0.1, 0.2, 0.3, 0.6, 1.5]])
    states = forecast_at(Straight(labelled), thrown(labelled), ahead)
    later = np.maximum(ahead, 0.005)[..., None]
    np.testing.assert_allclose(states[..., :3], LAUNCH[:, None] + later * VELOCITY[:, None])
    np.testing.assert_allclose(states[..., 3:6], VELOCITY[:, None].repeat(6, axis=1))
    np.testing.assert_allclose(states[..., 6:], labelled * SPIN[:, None].repeat(6, axis=1))


def test_a_simulator_flies_on():
    history, _ = observed()
    ahead = np.array([0.1, 0.45, 0.8])
    flown = forecast_at(PhysicsPredictor(TRUTH), history, np.tile(ahead, (3, 1)))
    near = PhysicsPredictor(TRUTH).predict(history).states
    np.testing.assert_allclose(flown[:, 0], near[:, 19], atol=1e-9)
    on = TRUTH.fly(near[:, 19], ahead - 0.1).states
    np.testing.assert_allclose(flown, on, atol=1e-5)
