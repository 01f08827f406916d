"""Forecasts of incoming balls: the right instants, and no error but the forecaster's."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.policy.forecasts import (
    exact,
    filtered_balls,
    first_state,
    forecast_error,
    re_anchored,
)
from rallygap.models.policy.incoming_balls import (
    FIRST_WINDOW,
    IncomingBalls,
    control_times,
    fly_incoming,
)
from rallygap.models.policy.launches import draw_launches, is_playable
from rallygap.models.policy.measurements import measure
from rallygap.models.policy.settings import SensorNoise
from tests.models.policy.incoming_balls import (
    HORIZONS,
    THROWN,
    TRUTH,
    VACUUM,
    WRONG,
    parabola,
    struck,
)
from tests.models.policy.schooling import TASK


def test_a_parabola_is_forecast_at_its_ticks_and_horizons():
    path, _ = fly_incoming(VACUUM, THROWN)
    expected = parabola(control_times(0.0)[:, None] + np.array(HORIZONS) / 1000)
    for forecasts in (
        exact(path, HORIZONS),
        first_state(VACUUM, THROWN, HORIZONS),
        re_anchored(VACUUM, path, HORIZONS),
    ):
        np.testing.assert_allclose(forecasts, expected[None], atol=1e-8)


def test_a_wrong_simulator_errs_along_the_flight_unless_it_is_re_anchored():
    launches, path, playable = struck()
    live = control_times(0.0) < playable[:, 1:] - 0.2
    truth = exact(path, HORIZONS)
    first = np.linalg.norm((first_state(WRONG, launches, HORIZONS) - truth)[..., 1, :3], axis=2)
    again = np.linalg.norm((re_anchored(WRONG, path, HORIZONS) - truth)[..., 1, :3], axis=2)
    assert 0.002 < again[live].mean() < 0.02 < 0.05 < first[live].mean()
    np.testing.assert_allclose(first[:, 0], again[:, 0], atol=1e-9)


def test_the_forecast_error_counts_until_the_ball_is_gone():
    _, path, playable = struck()
    forecasts = exact(path, HORIZONS)
    forecasts[..., 1, 0] += 0.03
    forecasts[..., [0, 2], 0] += 0.5  # other horizons
    forecasts[control_times(0.0) >= playable[:, 1:]] += 7.0
    incoming = IncomingBalls(path, playable, 0.0, forecasts)
    assert forecast_error(incoming, HORIZONS) == pytest.approx(0.03)


def test_measurements_are_the_path_every_five_milliseconds_until_it_is_lost_with_noise():
    _, path, playable = struck()
    clean = SensorNoise(position=0.0, spin=0.0)
    seen, mask = measure(path, playable[:, 1], clean, np.random.default_rng(0))
    counts = np.floor(playable[:, 1] / 0.005 + 1e-6) + 1
    np.testing.assert_array_equal(mask.sum(axis=1), np.tile(counts[:, None], 6))
    true = np.concatenate([path[:, ::5, :3], path[:, ::5, 6:]], axis=2)
    np.testing.assert_array_equal(seen, np.where(mask, true, 0.0))
    noise = SensorNoise(position=0.003, spin=0.05)
    seen, _ = measure(path, np.full(len(path), np.inf), noise, np.random.default_rng(0))
    size = np.linalg.norm(true[..., 3:], axis=2, keepdims=True)
    assert (seen - true)[..., :3].std() == pytest.approx(0.003, rel=0.03)
    assert ((seen - true)[..., 3:] / size).std() == pytest.approx(0.05, rel=0.03)


def test_forecasts_are_near_the_future_while_balls_are_in_play_and_spreads_say_how_near():
    random = np.random.default_rng(0)
    path, playable = fly_incoming(TRUTH, draw_launches(TRUTH, 80, random))
    incoming = filtered_balls(TRUTH, path, playable, HORIZONS, random)
    away = (incoming.forecasts - exact(path, HORIZONS, FIRST_WINDOW))[..., :3]
    in_play = control_times(FIRST_WINDOW) < playable[:, 1:]
    assert np.median(np.linalg.norm(away, axis=-1)[in_play]) == pytest.approx(0.01, rel=0.5)
    assert not incoming.forecasts[~in_play].any() and not incoming.spreads[~in_play].any()
    shares = (away / incoming.spreads.clip(1e-9))[in_play]
    spread = np.median(np.abs(shares)) / 0.6745
    assert 0.5 < spread < 1.2  # the filter allows for an imperfect simulator


@pytest.mark.parametrize(("kind", "start"), [("exact", 0.0), ("exact_after_window", FIRST_WINDOW)])
def test_a_task_draws_playable_balls_with_exact_forecasts_and_a_goal_each(kind, start):
    incoming, goals = replace(TASK, forecasts=kind).draw(7, np.random.default_rng(0))
    assert len(incoming) == len(goals) == 7
    assert incoming.start == start and np.isfinite(incoming.playable).all()
    assert is_playable(TASK.simulator, incoming.path[:, 0]).all()
    expected = exact(incoming.path, TASK.horizons, start)
    np.testing.assert_array_equal(incoming.forecasts, expected)
