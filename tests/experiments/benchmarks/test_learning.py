"""The training benchmark stops at the goal, at the last iteration or when its time is used up."""

import math
from itertools import count

import pytest

from experiments.benchmarks import learning
from experiments.benchmarks.learning import LEARNING, Progress, compared, train


@pytest.mark.parametrize(
    ("rates", "iterations", "patience", "trained"),
    [
        ([0.3, 0.949, 0.95, 0.98], None, math.inf, 3),
        ([0.1] * 5, 3, math.inf, 3),
        ([0.1] * 5, None, 1e-9, 1),
    ],
)
def test_training_stops(monkeypatch, rates, iterations, patience, trained):
    monkeypatch.setattr(learning, "return_rate", lambda number, seed: rates[number])
    progress = train("it", iter(range(iterations)) if iterations else count(), patience, 1)
    assert progress.steps == LEARNING.steps_per_iteration * trained
    assert progress.return_rate == rates[trained - 1]


FAST, SLOW, MISSED = (
    Progress(64_000, 100.0, 0.96),
    Progress(96_000, 200.0, 0.97),
    Progress(96_000, 200.0, 0.9),
)
PEER, PEER_MISSED = Progress(96_000, 1500.0, 0.97), Progress(192_000, 3000.0, 0.42)


@pytest.mark.parametrize(
    ("ours", "peer", "expected"),  # seconds, ratio, whether it is a lower bound
    [
        ([FAST], [PEER], (100.0, 15.0, False)),
        ([FAST, SLOW], [PEER] * 2, (150.0, 10.0, False)),
        ([FAST], [PEER_MISSED], (100.0, 30.0, True)),
        ([FAST, MISSED], [PEER] * 2, (150.0, None, False)),
    ],
)
def test_seeds_are_averaged_and_a_ratio_to_a_peer_that_missed_the_goal_is_a_lower_bound(
    ours, peer, expected
):
    _, seconds = compared(ours, peer)
    assert (seconds.rallygap, seconds.ratio, seconds.lower_bound) == expected
