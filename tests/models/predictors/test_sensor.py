"""Forecasts by a simulator with sensor effects are in the coordinates of its measurements."""

import numpy as np
import pytest

from rallygap.models.ball.sensor import measured
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import FUTURE_TIMES, HISTORY_TIMES, History
from rallygap.models.predictors.sensor import Sensor
from tests.models.predictors.balls import FIRST, TRUTH

NODES = [[0.0, y, 0.3, 0.5, 1.0, -0.8] for y in (-1.0, 0.0, 1.0)]
CAMERAS = (
    TRUTH.amended("camera_distortion", amplitude=0.01, length=0.8, nodes=NODES)
    .amended("frame_tilt", x=0.02, y=-0.03)
    .amended("position_scale", s=0.01)
    .amended("spin_gain", s=0.1)
    .amended("clock_rate", d=0.02)
)


def balls():
    """Histories and futures as these cameras measure them, without noise."""
    times = np.concatenate([HISTORY_TIMES, FUTURE_TIMES]) - HISTORY_TIMES[0]
    places, spins = measured(CAMERAS, FIRST, times, np.random.default_rng(0))
    states = np.concatenate([places, spins], axis=-1)[:, : len(HISTORY_TIMES)]
    return History(states, np.ones(states.shape, dtype=bool)), places[:, len(HISTORY_TIMES) :]


def test_true_balls_are_found_behind_measurements():
    sensor = Sensor(CAMERAS)
    states = TRUTH.fly(FIRST, FUTURE_TIMES).states
    seen = sensor.measured_states(states)
    assert sensor.true_positions(seen[..., :3]) == pytest.approx(states[..., :3], abs=1e-6)
    assert sensor.true_spins(seen[..., 6:]) == pytest.approx(states[..., 6:])
    assert np.linalg.norm(seen[..., :3] - states[..., :3], axis=-1).max() > 0.02


def test_a_velocity_is_the_slope_of_measured_positions():
    sensor, step = Sensor(CAMERAS), 1e-5
    later = TRUTH.fly(FIRST, [0.0, 0.1, 0.1 + step]).states
    seen = sensor.measured_states(later)
    slope = (seen[:, 2, :3] - seen[:, 1, :3]) / (step * sensor.clock)
    assert seen[:, 1, 3:6] == pytest.approx(slope, abs=0.02)


def test_forecasts_are_those_of_the_measurements():
    history, future = balls()
    errors = [
        np.linalg.norm(PhysicsPredictor(one).predict(history).states[..., :3] - future, axis=-1)
        for one in (CAMERAS, TRUTH)
    ]
    assert errors[0].max() < 0.01
    assert errors[1].max() > 5 * errors[0].max()
