"""Launches vary widely, clear the net and come from both sides."""

import numpy as np

from tests.experiments.exam.example_trials import NOMINAL, drawn

LAUNCHES = drawn(shots=600)
CONTACTS = NOMINAL.fly(LAUNCHES.states, [0.0, 2.0]).contacts
BOUNCES = (CONTACTS.time < LAUNCHES.durations[:, None]).sum(axis=1)  # that are seen


def test_speeds_and_spins_range_widely():
    speed = np.linalg.norm(LAUNCHES.states[:, 3:6], axis=1)
    spin = np.abs(LAUNCHES.states[:, 6:])

    assert speed.min() >= 4.0
    assert speed.max() <= 15.0
    assert np.percentile(speed, 97) > 3 * np.percentile(speed, 3)
    assert np.linalg.norm(LAUNCHES.states[:, 6:], axis=1).max() <= 400.0
    assert (spin.max(axis=0) > 300.0).all()


def test_most_shots_bounce_once_some_not_and_some_twice():
    share = np.bincount(BOUNCES, minlength=4) / len(LAUNCHES.states)

    assert 0.6 < share[1] < 0.9
    assert 0.03 < share[0] < 0.15
    assert 0.05 < share[2] < 0.3
    assert share[3] == 0
    before = CONTACTS.time[BOUNCES == 1, 0]
    after = LAUNCHES.durations[BOUNCES == 1] - before
    assert 0.25 < np.median(before) < 0.35
    assert 0.25 < np.median(after) < 0.35


def test_balls_clear_the_net():
    times = LAUNCHES.durations[:, None] * np.linspace(0, 1, 2000)
    y, z = np.moveaxis(NOMINAL.fly(LAUNCHES.states, times).states[..., 1:3], -1, 0)

    over = np.abs(y) < 0.02

    assert over.any(axis=1).mean() > 0.5
    assert z[over].min() > 0.1525 + 0.02


def test_two_directions_are_played_equally_often_and_one_is_towards_the_robot():
    one = drawn(directions=1).states

    assert (LAUNCHES.states[:, 4] > 0).mean() == 0.5
    assert (one[:, 4] < 0).all()
