"""Degenerate shots: all finite numbers have a verdict with plausible values."""

import re
from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.gap.fit.horizons import first_samples
from tests.models.gap.hidden import NOMINAL, measured

SHOTS, BARE = (measured(count=6, seconds=0.4, labels=labels) for labels in ("rows", None))


def checked(shots, simulator=NOMINAL):
    """The verdict, whose numbers are finite and whose estimates and shares are plausible."""
    verdict = diagnose(shots, simulator)
    assert not re.search("NaN|Infinity", verdict.to_json())
    for cause in verdict.causes:
        assert cause.interval[0] <= cause.estimate <= cause.interval[1]
        assert 0.0 <= cause.gap_share <= 1.0 + 1e-9
    assert 0.0 <= verdict.unexplained.share <= 1.0
    return verdict


@pytest.mark.parametrize("count", [1, 13])
def test_few_samples(count):
    assert checked(first_samples(BARE, count)).verdict == "no_gap"


def test_no_noise_or_more_than_the_table():
    exact = {"noise": 0.0, "label": 0.0, "scatter": (0.0, 0.0, 0.0)}
    assert checked(measured(count=6, seconds=0.4, **exact)).verdict == "no_gap"
    assert checked(measured(count=6, seconds=0.4, noise=2.0)).causes == ()


def test_equal_shots_balls_that_do_not_move_and_millimetres():
    assert checked(SHOTS[np.zeros(6, dtype=int)]).causes == ()
    checked(replace(SHOTS, positions=np.ones_like(SHOTS.positions)))
    checked(replace(BARE, positions=1000 * BARE.positions))


def test_labels_in_some_shots_only_and_labels_that_cannot_be():
    without = np.arange(6) % 2 == 0
    times = np.where(without[:, None], np.nan, SHOTS.label_times)
    labels = np.where(without[:, None, None], np.nan, SHOTS.labels)
    assert checked(replace(SHOTS, label_times=times, labels=labels)).verdict == "no_gap"
    for factor in (0.0, 100.0):
        checked(replace(SHOTS, labels=factor * SHOTS.labels))


def test_simulators_without_most_effects():
    checked(SHOTS, Simulator.from_dict({"gravity": {"g": 9.81}}))
    checked(BARE, Simulator.from_dict({}))
