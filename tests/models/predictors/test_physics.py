"""The physics predictor: exact with the true simulator and sensor, robust to outliers."""

import numpy as np
import pytest
from scipy.interpolate import interp1d

from rallygap.models.ball.sensor import measured
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import FUTURE_TIMES, HISTORY_TIMES, History
from rallygap.models.predictors.sensor import Sensor
from tests.models.predictors.balls import FIRST, TRUTH, observed

TRUE_PHYSICS = PhysicsPredictor(TRUTH)

# Balls that bounce between 8 and 56 ms after their first measurement, from tick 2 to tick 11.
BOUNCING = np.tile(FIRST[1], (7, 1))
BOUNCING[:, 2] = np.linspace(0.04, 0.16, 7)


def misses(history, future):
    """By how much forecasts of the last positions are off."""
    forecast = TRUE_PHYSICS.predict(history)
    return np.linalg.norm((forecast.states - future)[:, -1, :3], axis=1)


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
    assert misses(history, future).max() < 1e-3
    spins = TRUE_PHYSICS.predict(history).states[..., 6:]
    assert np.abs(spins - future[..., 6:]).max() < 2.0


def test_two_outliers_and_a_lost_measurement_at_the_end_are_no_new_ball():
    """A history like one of the arena that once threw the forecast off by metres."""
    history, future = observed(noise=0.003)
    ending = degraded(history, {10: [0.05, 0.0, -0.2], 11: [-0.1, 0.0, 0.14]}, lost=[9])
    clean = misses(history, future)
    assert (misses(ending, future) < 3 * clean + 0.03).all()


@pytest.mark.parametrize("where", [0, 1, 2, 7, 11])
def test_an_outlier_does_not_bend_the_forecast(where):
    history, future = observed(noise=0.001)
    spoilt = degraded(history, {where: [0.1, 0.05, -0.08]}, lost=[])
    clean = misses(history, future)
    assert (misses(spoilt, future) < clean + 0.03).all()


@pytest.mark.parametrize("neighbours", [[-1, 1], [-2, -1], [1, 2]], ids=str)
@pytest.mark.parametrize("where", range(12))
def test_values_interpolated_towards_an_outlier(where, neighbours):
    lost = [place for place in np.add(where, neighbours) if 0 < place < 11]
    history, future = observed(np.vstack([FIRST, BOUNCING]), noise=0.003, seed=where)
    offsets = np.random.default_rng(where).normal(size=(len(history), 3))
    offsets *= 0.25 / np.linalg.norm(offsets, axis=1, keepdims=True)
    interpolated = degraded(history, {where: offsets}, lost)
    clean = misses(history, future)
    assert (misses(interpolated, future) < 3 * clean + 0.1).all()


@pytest.mark.parametrize("struck_at", [2, 5, 7])
def test_a_ball_struck_inside_the_history_is_found_again(struck_at):
    history, future = observed(noise=0.001)
    before = HISTORY_TIMES[:struck_at] - HISTORY_TIMES[struck_at]
    states = history.states.copy()
    states[:, :struck_at, :3] -= before[:, None] * np.array([0.0, 16.0, -2.0])
    struck = History(states, history.mask)
    assert (misses(struck, future) < 0.15).all()


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
