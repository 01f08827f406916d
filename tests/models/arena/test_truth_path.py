"""The true path: what perfect cameras see, at multiples of their interval, and nothing else."""

import numpy as np
import pytest

from rallygap.models.arena.truth_path import true_states
from tests.models.arena.sessions import TRUTH, games, session


def test_perfect_cameras_see_the_true_path_at_multiples_of_their_interval():
    for recording in session()[::7]:
        steps = recording.times / 0.005
        assert steps == pytest.approx(np.round(steps)), recording.name
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
