"""Systematic errors of a session: one field for all recordings, one label error for each arc."""

from functools import cache
from itertools import pairwise
from unittest.mock import patch

import numpy as np
import pytest

from rallygap.models.arena.session import recordings
from rallygap.models.arena.truth_path import true_states
from rallygap.models.ball.state import POSITION, SPIN
from tests.models.arena.sessions import HIDDEN, settings


@cache
def session():
    """Shots and a few games, seen by cameras without random errors, with the true states."""
    batches = {"CANNON_BATCH": 80, "MATCH_BATCH": 6}
    with patch.multiple("rallygap.models.arena.session", **batches):
        seen = list(recordings(settings(game_episodes=100, cannon_shots=80), HIDDEN, 0))
    return [(one, true_states(HIDDEN, one.contacts, one.times)) for one in seen]


def test_all_recordings_have_the_same_field():
    assert {one.name.split("/")[0] for one, _ in session()} >= {"cannon", "amateur", "pro"}
    for recording, states in session():
        field = HIDDEN.camera_field.errors(states[:, POSITION])
        np.testing.assert_allclose(recording.positions - states[:, POSITION], field, atol=1e-6)


def test_label_errors_are_constant_between_contacts_and_those_of_neighbours_independent():
    pairs = []
    for recording, states in session():
        spin = np.linalg.norm(states[:, SPIN], axis=1)
        # A sample at a contact belongs to either arc; a tossed ball has no spin.
        apart = np.abs(recording.times[:, None] - recording.contacts.times).min(axis=1) > 1e-6
        used = apart & (spin > 1.0)
        errors = (recording.spins - states[:, SPIN])[used] / spin[used, None]
        arc = np.searchsorted(recording.contacts.times, recording.times[used], side="right")
        arcs = [errors[arc == number] for number in np.unique(arc)]
        assert all(np.ptp(of_arc, axis=0).max() < 1e-5 for of_arc in arcs)
        pairs += [(before[0], after[0]) for before, after in pairwise(arcs)]
    before, after = np.swapaxes(pairs, 0, 1)

    assert before.std() == pytest.approx(HIDDEN.arc_spin_noise, rel=0.1)
    assert after.std() == pytest.approx(HIDDEN.arc_spin_noise, rel=0.1)
    assert len(pairs) > 200
    assert abs(np.corrcoef(before.ravel(), after.ravel())[0, 1]) < 0.1
