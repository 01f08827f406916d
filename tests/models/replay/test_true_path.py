"""The true path of the arena's balls: the sealed truth, until the next stroke."""

import numpy as np
import pytest

from rallygap.models.arena.truth_path import true_states
from rallygap.models.policy.incoming_balls import PATH_TIMES
from rallygap.models.replay.replayed_balls import fly_on
from rallygap.models.replay.shots import Shot
from rallygap.models.replay.true_path import true_path
from tests.models.arena.sessions import TRUTH, games, session


def rallies():
    """The contacts of six recordings with a rally in them."""
    return [game.contacts for game in games() if (game.contacts.kinds == "racket").sum() > 3][:6]


def strokes(contacts):
    return contacts.times[np.isin(contacts.kinds, ["racket", "launch"])]


@pytest.mark.parametrize("late", [-0.002, 0.0, 0.004])
def test_a_replayed_ball_is_where_it_truly_was_until_the_next_stroke(late):
    for contacts in rallies():
        own, following = strokes(contacts)[1:3]
        known, bounces = true_path(TRUTH, contacts, own + late)
        times = own + late + PATH_TIMES[: len(known)]
        np.testing.assert_array_equal(known, true_states(TRUTH, contacts, times))
        assert times[-1] < following
        assert times[-1] > following - 0.0011 or len(known) == len(PATH_TIMES)
        between = (contacts.times > own + late) & (contacts.times < times[-1])
        tables = contacts.times[between & (contacts.kinds == "table")]
        np.testing.assert_allclose(bounces, tables - own - late)


def test_it_then_flies_on_in_the_hidden_physics():
    contacts = rallies()[0]
    known, bounces = true_path(TRUTH, contacts, strokes(contacts)[1])
    shot = Shot(session()[0], known, bounces)
    path, _ = fly_on(TRUTH.simulator, [shot])
    onward = TRUTH.simulator.fly(known[-1], [0.1]).states[0, 0]
    np.testing.assert_array_equal(path[0, : len(known)], known)
    np.testing.assert_allclose(path[0, len(known) - 1 + 100], onward)


def test_the_last_stroke_is_followed_until_the_ball_is_lost():
    contacts = session()[-1].contacts
    start = strokes(contacts)[-1]
    known, _ = true_path(TRUTH, contacts, start)
    seen = np.isfinite(true_states(TRUTH, contacts, start + PATH_TIMES)[:, 0])
    assert np.isfinite(known).all() and seen[: len(known)].all()
    assert len(known) == len(PATH_TIMES) or not seen[len(known)]
