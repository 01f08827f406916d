"""Launches vary widely, clear the net and come from both sides."""

import numpy as np

from tests.experiments.exam.example_trials import NOMINAL, drawn

LAUNCHES = drawn(shots=600)


def test_speeds_and_spins_range_widely_and_come_from_both_sides_or_towards_the_robot():
    speed = np.linalg.norm(LAUNCHES.states[:, 3:6], axis=1)
    assert speed.min() >= 4.0 and speed.max() <= 15.0
    assert np.percentile(speed, 97) > 3 * np.percentile(speed, 3)
    assert np.linalg.norm(LAUNCHES.states[:, 6:], axis=1).max() <= 400.0
    assert (np.abs(LAUNCHES.states[:, 6:]).max(axis=0) > 300.0).all()
    assert (LAUNCHES.states[:, 4] > 0).mean() == 0.5
    assert (drawn(directions=1).states[:, 4] < 0).all()


def test_balls_clear_the_net_and_most_bounce_once_some_not_and_some_twice():
    contacts = NOMINAL.fly(LAUNCHES.states, [0.0, 2.0]).contacts
    bounces = (contacts.time < LAUNCHES.durations[:, None]).sum(axis=1)  # that are seen
    never, once, twice, more = np.bincount(bounces, minlength=4) / len(bounces)
    assert 0.03 < never < 0.15 and 0.6 < once < 0.9 and 0.05 < twice < 0.3 and more == 0
    before = contacts.time[bounces == 1, 0]
    for seconds in (before, LAUNCHES.durations[bounces == 1] - before):
        assert 0.25 < np.median(seconds) < 0.35
    times = LAUNCHES.durations[:, None] * np.linspace(0, 1, 2000)
    y, z = np.moveaxis(NOMINAL.fly(LAUNCHES.states, times).states[..., 1:3], -1, 0)
    over = np.abs(y) < 0.02
    assert over.any(axis=1).mean() > 0.5
    assert z[over].min() > 0.1525 + 0.02
