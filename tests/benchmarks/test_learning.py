"""The race to 90 % returns ends where it must and is told as it was."""

import io
import math
from itertools import count

import pytest
from rich.console import Console

from benchmarks import learning as bench_learning
from benchmarks.learning import LEARNING, Mark, marks, result


def course(monkeypatch, returned, legs=None, patience=math.inf):
    """The marks of somebody who returns these shares of the balls, leg by leg."""
    monkeypatch.setattr(bench_learning, "return_rate", lambda leg: returned[leg])
    return list(marks(iter(range(legs)) if legs else count(), patience))


def shown(our, their):
    page = io.StringIO()
    Console(file=page, width=120).print(result(our, their))
    return page.getvalue()


def test_it_ends_with_the_first_leg_that_reaches_the_goal(monkeypatch):
    found = course(monkeypatch, [0.3, 0.899, 0.9, 0.95])
    assert [mark.returned for mark in found] == [0.3, 0.899, 0.9]
    assert [mark.ticks for mark in found] == [LEARNING.ticks * leg for leg in (1, 2, 3)]


def test_it_ends_with_the_last_leg_where_the_goal_is_not_reached(monkeypatch):
    found = course(monkeypatch, [0.1] * 5, legs=3)
    assert [mark.returned for mark in found] == [0.1] * 3


def test_it_ends_when_the_patience_does(monkeypatch):
    assert len(course(monkeypatch, [0.1] * 5, patience=1e-9)) == 1


@pytest.mark.parametrize(
    ("our", "their", "told"),
    [
        (Mark(64_000, 100.0, 0.91), Mark(96_000, 1500.0, 0.92), " 15.0 x"),
        (Mark(64_000, 100.0, 0.91), Mark(192_000, 3000.0, 0.42), "more than 30.0 x"),
        (Mark(192_000, 100.0, 0.89), Mark(96_000, 1500.0, 0.92), "not there"),
    ],
)
def test_a_ratio_is_told_only_as_far_as_it_is_known(our, their, told):
    seconds = next(line for line in shown(our, their).splitlines() if "seconds" in line)
    assert told in seconds
    assert ("more than" in seconds) == told.startswith("more than")
