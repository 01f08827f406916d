"""The watch collects shots, has them looked at by another process, and tells what has changed."""

import time
from unittest.mock import Mock

import numpy as np
import pytest

from rallygap.models.live.forecaster import Forecaster
from rallygap.pipeline.live.messages import Measurement
from rallygap.pipeline.live.watch import Watch
from tests.pipeline.live.example_frames import ALARM, FIRST, PLACES, TIMES, TRUTH


def watched(watch, count):
    """Watch a ball that is thrown again and again; return the last one."""
    forecaster = Forecaster(TRUTH)
    for number in range(count):
        for k, (t, place) in enumerate(zip(TIMES, PLACES, strict=True)):
            row = Measurement(k, number + t, place, FIRST[6:] if k == 0 else None)
            seen = forecaster.observe(row.time, row.position, spin=row.spin)
            watch.observe(row, seen, forecaster.ball)
    return forecaster.ball


def test_each_ball_is_a_shot_once_the_next_one_has_come_until_an_alarm_ends_the_watch(monkeypatch):
    told, worker = [], Mock()
    worker.submit.return_value.result.side_effect = [None, ALARM]
    watch = Watch(TRUTH, told.append)
    monkeypatch.setattr(watch, "_worker", worker)
    watched(watch, 5)
    assert (watch.alarm, told) == (ALARM, [ALARM])
    shots = [call.args[1] for call in worker.submit.call_args_list]
    assert len(shots) == 2
    for number, (times, positions, spins) in enumerate(shots):
        assert times == pytest.approx(number + TIMES, abs=1e-9)
        assert positions == pytest.approx(PLACES)
        assert np.isfinite(spins[:, 0]).nonzero()[0].tolist() == [0]


def test_the_other_process_takes_shots():
    watch = Watch(TRUTH, print)
    ball = watched(watch, 2)
    deadline = time.monotonic() + 60
    while watch._pending and time.monotonic() < deadline:
        time.sleep(0.1)
        watch.observe(Measurement(0, 9.0, None), "unused", ball)
    watch.close()
    assert not watch._pending
    assert watch.alarm is None
