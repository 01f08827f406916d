"""Landings and clearances: closed forms, and the evaluation of returns."""

import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.outcome import judge
from rallygap.models.shot_quality.shots import FEATURES, clearance, landings, shot_features

VACUUM = Simulator.from_dict(
    {"gravity": {"g": 9.81}, "table_bounce": {"restitution": 0.9, "friction": 0.25}}
)
STRUCK = np.array([[0.1, -1.5, 0.3, 0.2, 5.0, 1.5, -100.0, 20.0, 10.0]])


def test_without_air_a_ball_lands_where_a_parabola_does():
    fall = STRUCK[0, 2] - BALL_RADIUS
    time = (1.5 + np.sqrt(1.5**2 + 2 * 9.81 * fall)) / 9.81
    expected = [0.1 + 0.2 * time, -1.5 + 5 * time, BALL_RADIUS, 0.2, 5.0, 1.5 - 9.81 * time]
    assert landings(VACUUM, STRUCK)[0] == pytest.approx([*expected, -100.0, 20.0, 10.0], abs=1e-6)


def test_returns_land_where_their_evaluation_says():
    simulator = shipped("literature")
    random = np.random.default_rng(0)
    after = STRUCK + random.normal(scale=[0.1, 0.1, 0.1, 0.5, 1, 1, 50, 20, 20], size=(300, 9))
    outcome = judge(simulator, after, Goals(np.zeros((300, 2))))
    returned = outcome.returned
    assert returned.sum() > 50
    landed = landings(simulator, after[returned])
    assert (landed[:, :2] == outcome.landing[returned]).all()
    assert np.abs(landed[:, 2] - BALL_RADIUS).max() < 1e-6
    assert clearance(outcome.net_height[returned]).min() > -0.03  # over the cord at the lowest


def test_features_omit_the_height_at_the_bounce():
    state = np.arange(9.0)[None]
    row = shot_features(state, np.array([0.5]))[0]
    assert dict(zip(FEATURES, row, strict=True)) == {
        "across": 0, "along": 1, "vx": 3, "vy": 4, "vz": 5, "wx": 6, "wy": 7, "wz": 8,
        "clearance": 0.5,
    }  # fmt: skip


def test_a_ball_that_just_touches_the_net_s_top_has_no_clearance():
    assert clearance(np.array([0.1725])) == pytest.approx([0.0])
