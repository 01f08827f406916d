"""Drift: a change is named within shots, and nothing else raises an alarm."""

from copy import copy

import numpy as np
import pytest

from rallygap.models.live.drift import DriftMonitor, Session
from tests.models.gap.hidden import NOMINAL, measured


@pytest.fixture(scope="module")
def reference():
    return measured(count=80, seed=11)


@pytest.fixture(scope="module")
def learned(reference):
    return DriftMonitor(reference, NOMINAL)


@pytest.fixture
def monitor(learned):
    """A monitor that has seen its reference alone."""
    return copy(learned)


def first(alarms):
    return next(((k, one) for k, one in enumerate(alarms, 1) if one is not None), None)


def test_a_world_that_stays_raises_no_alarm(monitor, reference):
    assert first(monitor.add(measured(count=100, seed=12))) is None
    # What the simulator gets wrong all the time is no change.
    off = DriftMonitor(reference, NOMINAL.amended("drag", cd=0.53))
    assert first(off.add(measured(count=60, seed=14))) is None


@pytest.mark.parametrize(
    ("effect", "parameter", "before", "value"),
    [
        ("drag", "cd", 0.5, 0.56),
        ("wind", "y", 0.0, 0.3),
        ("table_bounce", "restitution", 0.92, 0.88),
    ],
)
def test_a_change_is_named_with_its_size(monitor, effect, parameter, before, value):
    changed = NOMINAL.amended(effect, **{parameter: value})
    shots, alarm = first(monitor.add(measured(changed, 20, seed=13)))
    assert shots <= 12
    assert alarm.hypothesis.identity == f"{effect}.{parameter}"
    assert alarm.possible[0] == alarm.hypothesis
    assert alarm.change == pytest.approx(value - before, abs=3 * alarm.error + 0.1 * abs(value))


def test_one_shot_of_another_world_raises_no_alarm(monitor):
    gust = measured(NOMINAL.amended("wind", x=3.0), count=1, seed=15)
    alarms = [*monitor.add(measured(count=10, seed=16)), *monitor.add(gust)]
    assert first([*alarms, *monitor.add(measured(count=20, seed=17))]) is None


def test_shots_may_come_one_by_one(monitor, learned):
    shots = measured(NOMINAL.amended("wind", y=0.3), count=12, seed=18)
    one_by_one = [monitor.add(shots[[k]])[0] for k in range(len(shots))]
    assert first(one_by_one)[0] == pytest.approx(first(copy(learned).add(shots))[0], abs=1)


def test_a_session_learns_its_reference_and_then_names_a_change():
    def shots(simulator, count, seed):
        found = measured(simulator, count, seed)
        for k in range(count):
            kept = found.valid[k]
            yield found.times[k, kept], found.positions[k, kept], found.labels[k, kept]

    session = Session(NOMINAL, reference=40)
    nonsense = 0.005 * np.arange(60), np.full((60, 3), 1e6), np.full((60, 3), np.nan)
    quiet = list(shots(NOMINAL, 45, seed=1))
    for shot in (*quiet[:39], nonsense, *quiet[39:]):
        assert session.add(shot) is None
    changed = NOMINAL.amended("table_bounce", restitution=0.87)
    alarms = [session.add(shot) for shot in shots(changed, 12, seed=2)]
    assert next(one for one in alarms if one).hypothesis.identity == "table_bounce.restitution"
