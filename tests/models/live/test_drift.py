"""Drift: a change is named within shots, and nothing else raises an alarm."""

import pytest

from rallygap.models.live.drift import DriftMonitor
from tests.models.gap.hidden import NOMINAL, measured

REFERENCE = measured(count=80, seed=11)


def first(alarms):
    return next(((k, one) for k, one in enumerate(alarms, 1) if one is not None), None)


def test_a_world_that_stays_raises_no_alarm():
    assert first(DriftMonitor(REFERENCE, NOMINAL).add(measured(count=120, seed=12))) is None


@pytest.mark.parametrize(
    ("effect", "parameter", "value"),
    [("drag", "cd", 0.56), ("wind", "y", 0.3), ("table_bounce", "restitution", 0.88)],
)
def test_a_change_is_named_with_its_size(effect, parameter, value):
    changed = NOMINAL.amended(effect, **{parameter: value})
    shots, alarm = first(DriftMonitor(REFERENCE, NOMINAL).add(measured(changed, 20, seed=13)))
    before = {"cd": 0.5, "y": 0.0, "restitution": 0.92}[parameter]
    assert shots <= 12
    assert alarm.hypothesis.identity == f"{effect}.{parameter}"
    assert alarm.possible[0] == alarm.hypothesis
    assert alarm.change == pytest.approx(value - before, abs=3 * alarm.error + 0.1 * abs(value))


def test_what_the_simulator_gets_wrong_all_the_time_is_no_change():
    off = NOMINAL.amended("drag", cd=0.53)
    assert first(DriftMonitor(REFERENCE, off).add(measured(count=60, seed=14))) is None


def test_one_shot_of_another_world_raises_no_alarm():
    monitor = DriftMonitor(REFERENCE, NOMINAL)
    gust = measured(NOMINAL.amended("wind", x=3.0), count=1, seed=15)
    alarms = [*monitor.add(measured(count=10, seed=16)), *monitor.add(gust)]
    assert first([*alarms, *monitor.add(measured(count=20, seed=17))]) is None


def test_shots_may_come_one_by_one():
    shots = measured(NOMINAL.amended("wind", y=0.3), count=12, seed=18)
    together = DriftMonitor(REFERENCE, NOMINAL).add(shots)
    monitor = DriftMonitor(REFERENCE, NOMINAL)
    one_by_one = [monitor.add(shots[[k]])[0] for k in range(len(shots))]
    assert first(one_by_one)[0] == pytest.approx(first(together)[0], abs=1)
