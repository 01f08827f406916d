"""Paths: the smooth one through measurements lies where the ball was; the true one is sealed."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.arena.truth_path import true_states
from rallygap.models.policy.incoming_balls import PATH_TIMES
from rallygap.models.replay.paths import measured_path, true_path
from tests.models.arena.sessions import TRUTH as ARENA
from tests.models.arena.sessions import games, session
from tests.models.policy.replayed_shots import SERVE, STROKE, sampled
from tests.models.predictors.balls import TRUTH


def errors(measured, first):
    """Distances of position, velocity and spin from the truth, as far as the path is known."""
    known, _ = measured_path(measured)
    off = known - TRUTH.fly(first, PATH_TIMES[: len(known)]).states[0]
    return [np.linalg.norm(off[:, part : part + 3], axis=1) for part in (0, 3, 6)]


@pytest.mark.parametrize("rate", [143.0, 179.0, 200.0])
@pytest.mark.parametrize("first", [STROKE, SERVE], ids=["stroke", "serve"])
def test_it_is_the_true_path_and_with_noise_nearer_to_it_than_the_samples(rate, first):
    measured = sampled(first, rate=rate)
    place, velocity, spin = errors(measured, first)
    assert len(place) == np.searchsorted(PATH_TIMES, measured.times[-1])
    assert place.max() < 0.004 and velocity.max() < 0.5
    assert np.median(place) < 3e-4 and np.median(velocity) < 0.02
    assert spin.max() < 1e-6
    np.testing.assert_array_equal(measured_path(measured)[1], measured.bounces)
    place, velocity, _ = errors(sampled(first, rate=rate, noise=0.003), first)
    assert np.sqrt((place**2).mean()) < 0.6 * 0.003 * np.sqrt(3)
    assert np.median(velocity) < 0.15


def test_outliers_are_left_out():
    measured = sampled()
    outlier = np.isin(np.arange(len(measured.times)), [0, 7, 40, 41, 90])
    moved = np.where(outlier[:, None], measured.positions + 0.4, measured.positions)
    place, _, _ = errors(replace(measured, positions=moved, outlier=outlier), STROKE)
    assert place.max() < 0.005


def test_the_bounce_turns_a_ball_without_label_as_its_velocity_tells():
    straight = np.array([*STROKE[:6], 0.0, 0.0, 0.0])
    measured = sampled(straight)
    measured = replace(measured, spins=np.full_like(measured.spins, np.nan))
    _, _, spin = errors(measured, straight)
    bounce = measured.bounces[0]
    after = TRUTH.fly(straight, [bounce + 0.01]).states[0, 0, 6:]
    assert spin[PATH_TIMES[: len(spin)] < bounce].max() == 0.0
    assert spin.max() < 0.05 * np.linalg.norm(after) and np.linalg.norm(after) > 50


def test_a_label_before_the_bounce_is_carried_through_it():
    measured = sampled()
    before = measured.times < measured.bounces[0]
    labelled = replace(measured, spins=np.where(before[:, None], measured.spins, np.nan))
    _, _, spin = errors(labelled, STROKE)
    assert spin.max() < 10.0


def test_the_path_ends_where_something_else_than_the_table_meets_the_ball():
    measured = sampled()
    struck = replace(measured, arc=measured.arc + (measured.times > 0.2), bounces=np.array([0.5]))
    known, bounces = measured_path(struck)
    last = measured.times[measured.times <= 0.2][-1]
    assert len(known) == np.searchsorted(PATH_TIMES, last) and len(bounces) == 0


def test_two_samples_tell_of_no_path():
    known, bounces = measured_path(sampled(until=0.005))
    assert known.shape == (0, 9) and bounces.shape == (0,)


def strokes(contacts):
    return contacts.times[np.isin(contacts.kinds, ["racket", "launch"])]


@pytest.mark.parametrize("late", [-0.002, 0.004])
def test_a_replayed_ball_is_where_it_truly_was_until_the_next_stroke(late):
    rallies = [game.contacts for game in games() if (game.contacts.kinds == "racket").sum() > 3]
    for contacts in rallies[:6]:
        own, following = strokes(contacts)[1:3]
        known, bounces = true_path(ARENA, contacts, own + late)
        times = own + late + PATH_TIMES[: len(known)]
        np.testing.assert_array_equal(known, true_states(ARENA, contacts, times))
        assert times[-1] < following
        assert times[-1] > following - 0.0011 or len(known) == len(PATH_TIMES)
        between = (contacts.times > own + late) & (contacts.times < times[-1])
        tables = contacts.times[between & (contacts.kinds == "table")]
        np.testing.assert_allclose(bounces, tables - own - late)


def test_the_last_stroke_is_followed_until_the_ball_is_lost():
    contacts = session()[-1].contacts
    start = strokes(contacts)[-1]
    known, _ = true_path(ARENA, contacts, start)
    seen = np.isfinite(true_states(ARENA, contacts, start + PATH_TIMES)[:, 0])
    assert np.isfinite(known).all() and seen[: len(known)].all()
    assert len(known) == len(PATH_TIMES) or not seen[len(known)]
