"""Balls whose forecasts come from measurements: they err as much as they say."""

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.policy.forecasts import exact, filtered_balls
from rallygap.models.policy.incoming_balls import FIRST_WINDOW, control_times, fly_incoming
from rallygap.models.policy.launches import draw_launches
from rallygap.models.policy.settings import GoalSettings
from rallygap.models.policy.task import Task

TRUTH = shipped("literature")
HORIZONS = (115, 120, 125)
GOALS = GoalSettings(landing_across=(-0.4, 0.4), landing_along=(0.5, 1.1), speed=None, topspin=None)


@pytest.fixture(scope="module")
def drawn():
    random = np.random.default_rng(0)
    path, playable = fly_incoming(TRUTH, draw_launches(TRUTH, 200, random))
    incoming = filtered_balls(TRUTH, path, playable, HORIZONS, random)
    true = exact(path, HORIZONS, FIRST_WINDOW)
    return incoming, true, control_times(FIRST_WINDOW) < playable[:, 1:]


def test_forecasts_are_near_the_true_future_as_long_as_a_ball_is_in_play(drawn):
    incoming, true, in_play = drawn
    away = np.linalg.norm((incoming.forecasts - true)[..., :3], axis=-1)[in_play]
    assert np.median(away) == pytest.approx(0.01, rel=0.5)
    assert not incoming.forecasts[~in_play].any() and not incoming.spreads[~in_play].any()


def test_spreads_are_as_large_as_the_errors(drawn):
    incoming, true, in_play = drawn
    shares = ((incoming.forecasts - true)[..., :3] / incoming.spreads.clip(1e-9))[in_play]
    spread = np.median(np.abs(shares)) / 0.6745
    assert 0.5 < spread < 1.2  # the filter allows for an imperfect simulator


def test_the_same_seed_draws_the_same_balls():
    task = Task(TRUTH, HORIZONS, GOALS, "spread", "filtered")
    (first, _), (second, _) = (task.draw(5, np.random.default_rng(1)) for _ in range(2))
    np.testing.assert_array_equal(first.forecasts, second.forecasts)
    np.testing.assert_array_equal(first[1:3].spreads, second.spreads[1:3])
