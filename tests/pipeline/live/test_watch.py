"""The watch collects shots, and tells what has changed."""

import time

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.live.drift import Alarm, Session
from rallygap.models.live.forecaster import Forecaster
from rallygap.pipeline.live.messages import Measurement, forecast_message
from rallygap.pipeline.live.watch import ShotCollector, Watch, alarm_sentence
from tests.models.gap.hidden import NOMINAL, measured

TRUTH = shipped("literature")
FIRST = np.array([0.1, 1.2, 0.35, 0.3, -6.0, 1.0, -150.0, 20.0, 30.0])
TIMES = 0.005 * np.arange(60)
PLACES = TRUTH.fly(FIRST, TIMES).states[0, :, :3]
ALARM = Alarm(
    Hypothesis("wind", "x"),
    change=0.31,
    error=0.04,
    shots=14,
    possible=(Hypothesis("wind", "x"), Hypothesis("frame_tilt", "x")),
)


def balls(count):
    """Measurements of a ball that is thrown again and again."""
    for number in range(count):
        for k, (t, place) in enumerate(zip(TIMES, PLACES, strict=True)):
            yield Measurement(k, number + t, place, FIRST[6:] if k == 0 else None)


def shots(simulator, count, seed):
    found = measured(simulator, count, seed)
    for k in range(count):
        kept = found.valid[k]
        yield found.times[k, kept], found.positions[k, kept], found.labels[k, kept]


def test_each_ball_is_a_shot_once_the_next_one_has_come():
    forecaster, collector, collected = Forecaster(TRUTH), ShotCollector(), []
    for row in balls(3):
        seen = forecaster.observe(row.time, row.position, spin=row.spin)
        shot = collector.observe(row, seen, forecaster.ball)
        collected += [] if shot is None else [shot]
    assert len(collected) == 2
    for number, (times, positions, spins) in enumerate(collected):
        assert times == pytest.approx(number + TIMES, abs=1e-9)
        assert positions == pytest.approx(PLACES)
        assert np.isfinite(spins[:, 0]).nonzero()[0].tolist() == [0]


def test_a_session_learns_its_reference_and_then_names_a_change():
    session = Session(NOMINAL, reference=40)
    assert not any(session.add(shot) for shot in shots(NOMINAL, 45, seed=1))
    changed = NOMINAL.amended("table_bounce", restitution=0.87)
    alarms = [session.add(shot) for shot in shots(changed, 12, seed=2)]
    assert next(one for one in alarms if one).hypothesis.identity == "table_bounce.restitution"


def test_a_path_of_no_ball_is_left_out():
    session = Session(NOMINAL, reference=3)
    nonsense = TIMES, np.full((60, 3), 1e6), np.full((60, 3), np.nan)
    assert session.add(nonsense) is None
    assert not any(session.add(shot) for shot in shots(NOMINAL, 5, seed=3))


def test_an_alarm_comes_back_from_the_other_process(monkeypatch):
    told = []
    watch = Watch(TRUTH, told.append)
    forecaster = Forecaster(TRUTH)
    monkeypatch.setattr(watch, "_worker", Answering())
    for row in balls(2):
        watch.observe(row, forecaster.observe(row.time, row.position), forecaster.ball)
    assert (watch.alarm, told) == (ALARM, [ALARM])


class Answering:
    """Answers every shot with an alarm."""

    def submit(self, function, shot):
        return self

    def done(self):
        return True

    def result(self):
        return ALARM


def test_the_other_process_takes_shots():
    watch, forecaster = Watch(TRUTH, print), Forecaster(TRUTH)
    for row in balls(3):
        watch.observe(row, forecaster.observe(row.time, row.position), forecaster.ball)
    deadline = time.monotonic() + 60
    while watch._pending and time.monotonic() < deadline:
        time.sleep(0.1)
        watch.observe(Measurement(0, 9.0, None), "unused", forecaster.ball)
    watch.close()
    assert not watch._pending
    assert watch.alarm is None


def test_an_alarm_is_said_and_published():
    message = alarm_sentence(ALARM)
    assert "wind.x (the air moves) has changed by +0.31 m/s (standard error 0.04)" in message
    assert "in the last 14 shots. Not separable from frame_tilt.x." in message
    assert '"drift": {"identity": "wind.x"' in forecast_message(1, "used", None, ALARM)
    assert '"drift": null' in forecast_message(1, "used", None)
