"""The true path: what perfect cameras see, at multiples of their interval, and nothing else."""

import numpy as np
import pytest

from rallygap.models.arena.cameras import Cameras, SlowError
from rallygap.models.arena.contacts import follow_contacts
from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.truth_path import TrackedBall, observe, true_states
from tests.models.arena.sessions import TRUTH, flying, games, session


def test_perfect_cameras_see_the_true_path():
    for recording in session()[::7]:
        states = true_states(TRUTH, recording.contacts, recording.times)

        assert np.abs(states[:, :3] - recording.positions).max() < 1e-6, recording.name
        assert states[:, 6:] == pytest.approx(recording.spins, abs=1e-3)


def test_no_contact_moves_a_ball():
    for recording in games()[::3]:
        contacts = recording.contacts
        later = contacts.kinds != "launch"

        before = true_states(TRUTH, contacts, contacts.times[later] - 1e-6)

        assert np.abs(before[:, :3] - contacts.states[later, :3]).max() < 5e-5


def test_there_is_no_ball_before_the_launch_and_long_after_the_end():
    contacts = session()[0].contacts
    times = [contacts.times[0] - 0.1, contacts.times[0] + 0.01, contacts.times[-1] + 5]

    states = true_states(TRUTH, contacts, np.array(times))

    assert np.isfinite(states).all(axis=1).tolist() == [False, True, False]


def balls(count, random):
    """Return balls that start at the extremes of the game, until their second contact."""
    launches = flying(count, random)
    flight = follow_contacts(TRUTH, launches, 1, random)
    return [
        TrackedBall(
            TrueContacts(np.array([0.001]), np.array(["launch"]), launches[None, row]), 0.001 + end
        )
        for row, end in enumerate(np.minimum(flight.times[:, 0], flight.last_visible))
    ]


def test_frames_lie_on_the_grid_between_launch_and_end():
    seen = balls(20, np.random.default_rng(0))
    cameras = Cameras(0.003, 0.05, 0.02, 0.01, SlowError(0.3, 0.05), interval=0.005)
    measured = observe(TRUTH, cameras, seen, np.random.default_rng(1))
    for ball, (times, _, _) in zip(seen, measured, strict=True):
        steps = times / 0.005
        assert steps == pytest.approx(np.round(steps))
        assert (times >= 0.001).all()
        assert (times <= ball.last_visible).all()
