"""What the policy sees."""

import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.observation import (
    CROSSING_SCALE,
    EARLIEST,
    LATEST,
    LIMIT,
    SPREAD_SCALE,
    observe,
    plane_crossing,
)
from rallygap.models.robot.constants import LOWER, SPEED, UPPER
from rallygap.models.robot.kinematics import racket

AIRLESS = Simulator.from_dict({"gravity": {"g": 9.81}})
RANDOM = np.random.default_rng(5)
JOINTS = RANDOM.uniform(LOWER, UPPER, (4, 6))
SPEEDS = RANDOM.uniform(-SPEED, SPEED, (4, 6))
BALLS = np.tile([0.1, 0.4, 0.3, 0.3, -6.0, 1.0, 50.0, 20.0, 0.0], (4, 3, 1))
SPREADS = RANDOM.uniform(0.0, 0.05, (4, 3, 3))
GOALS = Goals(np.tile([0.1, 0.9], (4, 1)), np.full(4, 6.0), np.full(4, 50.0))


def seen(kind, forecasts=BALLS, goals=GOALS, spreads=SPREADS):
    return observe(JOINTS, SPEEDS, forecasts, spreads, goals, kind)


def test_the_crossing_is_where_a_ball_without_air_passes_the_racket():
    racket_state = racket(JOINTS, SPEEDS)
    found = plane_crossing(racket_state, BALLS[:, 0])
    flown = AIRLESS.fly(BALLS[:, 0], found[:, :1]).states[:, 0]
    np.testing.assert_allclose(flown[:, 1], racket_state.position[:, 1])
    apart = (flown[:, :3] - racket_state.position)[:, [0, 2]]
    np.testing.assert_allclose(found[:, 1:], np.column_stack([apart, flown[:, 3:6]]))


@pytest.mark.parametrize(("along", "time"), [(-8.0, EARLIEST), (8.0, LATEST), (0.0, LATEST)])
def test_a_ball_far_from_crossing_is_still_seen_within_bounds(along, time):
    balls = BALLS.copy()
    balls[..., 4] = along
    balls[..., 1] = 40.0 * np.sign(along)
    assert np.isfinite(seen("intercept", balls)).all()
    assert np.abs(seen("intercept", 1e9 * balls)).max() == LIMIT
    assert (plane_crossing(racket(JOINTS, SPEEDS), balls[:, 0])[:, 0] == time).all()


def test_a_kind_adds_the_crossing_or_the_spreads_to_what_another_sees():
    strict, crossing, spread = (seen(kind) for kind in ("strict", "intercept", "spread"))
    crossings = plane_crossing(racket(JOINTS, SPEEDS), BALLS[:, 0]) / CROSSING_SCALE
    np.testing.assert_array_equal(crossing[:, : strict.shape[1]], strict)
    np.testing.assert_allclose(crossing[:, strict.shape[1] :], crossings, rtol=1e-6)
    scaled = SPREADS.reshape(4, -1) / SPREAD_SCALE
    np.testing.assert_array_equal(spread[:, : crossing.shape[1]], crossing)
    np.testing.assert_allclose(spread[:, crossing.shape[1] :], scaled, rtol=1e-6)


def test_a_predictor_without_spreads_cannot_serve_a_policy_that_observes_them():
    assert seen("intercept", spreads=None).shape == seen("intercept").shape
    with pytest.raises(ValueError, match="its predictor has none"):
        seen("spread", spreads=None)


def test_joints_are_seen_in_shares_of_what_they_can_do():
    ends = observe(
        np.array([LOWER, UPPER]), np.array([SPEED, -SPEED]), BALLS[:2], None, GOALS[:2], "strict"
    )
    np.testing.assert_allclose(ends[:, :12], np.outer([-1, 1], [1] * 6 + [-1] * 6), atol=1e-6)
