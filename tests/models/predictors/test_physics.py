"""The physics predictor: exact where its simulator is true, robust where the cameras are not."""

import numpy as np
import pytest

from models.ball.simulators import shipped
from models.predictors.physics import PhysicsPredictor
from models.predictors.protocol import History
from tests.models.predictors.balls import FIRST, TRUTH, observed

TRUE_PHYSICS = PhysicsPredictor(TRUTH)


def position_error(forecast, future, at):
    return np.linalg.norm(forecast.states[:, at, :3] - future[:, at, :3], axis=1)


def test_true_physics_on_clean_measurements_forecasts_to_a_millimetre():
    history, future = observed()
    forecast = TRUE_PHYSICS.predict(history)
    assert position_error(forecast, future, -1).max() < 1e-3
    assert np.abs(forecast.states[..., 6:] - future[..., 6:]).max() < 2.0


def test_a_bounce_inside_the_history_does_no_harm():
    times = np.arange(12) * 0.005
    assert TRUTH.fly(FIRST[1], times).contacts.count[0] == 1
    history, future = observed(FIRST[[1]])
    assert position_error(TRUE_PHYSICS.predict(history), future, -1)[0] < 1e-3


def test_noisy_measurements_cost_centimetres_not_decimetres():
    balls = np.tile(FIRST, (30, 1))
    history, future = observed(balls, noise=0.003)
    error = position_error(TRUE_PHYSICS.predict(history), future, -1)
    assert 0.003 < np.median(error) < 0.05


def test_wrong_drag_forecasts_too_far():
    history, future = observed(FIRST[[0]])
    low_drag = PhysicsPredictor(shipped("literature").amended("drag", cd=0.2))
    ahead = low_drag.predict(history).states[0, -1, 1] - future[0, -1, 1]
    assert ahead < -0.05


def test_the_path_of_an_unlabelled_ball_hints_at_its_spin():
    # 55 ms of path at 4 mm leave the spin uncertain by about 1,000 rad/s: a hint, no more.
    topspin, backspin = FIRST[0].copy(), FIRST[0].copy()
    topspin[6:], backspin[6:] = [-400, 0, 0], [400, 0, 0]
    history, _ = observed(np.array([topspin, backspin]), labelled=False)
    forecast = TRUE_PHYSICS.predict(history)
    assert forecast.states[0, -1, 6] < 0 < forecast.states[1, -1, 6]
    assert not forecast.spin_measured.any()


@pytest.mark.parametrize("where", [0, 1, 2, 7, 11])
def test_an_outlier_does_not_bend_the_forecast(where):
    history, future = observed(noise=0.001)
    states = history.states.copy()
    states[:, where, :3] += [0.1, 0.05, -0.08]
    spoilt = History(states, history.mask)
    clean = position_error(TRUE_PHYSICS.predict(history), future, -1)
    spoilt_error = position_error(TRUE_PHYSICS.predict(spoilt), future, -1)
    assert (spoilt_error < clean + 0.03).all()


@pytest.mark.parametrize("lost", [[3], [0, 1], [4, 5, 6, 7]])
def test_lost_measurements_are_bridged(lost):
    history, future = observed()
    mask = history.mask.copy()
    mask[:, lost] = False
    sparse = History(np.where(mask, history.states, 0.0), mask)
    assert position_error(TRUE_PHYSICS.predict(sparse), future, -1).max() < 5e-3
