"""Measurements are those of a camera server or of recordings; forecasts have what robots need."""

import json
import time

import numpy as np
import pandas as pd
import pytest

from rallygap.models.live.forecaster import Forecaster
from rallygap.pipeline.live.latency import Latencies, summary
from rallygap.pipeline.live.messages import (
    MessageError,
    ball_forecast,
    forecast_message,
    measurements,
    paced,
    parse,
)
from tests.pipeline.live.example_frames import ALARM, FIRST, TRUTH

FRAME = {"num": 7, "time": 1_500_000_000, "proc_time": 1, "obs": [0.1, -0.2, 0.3]}


def test_a_measurement_has_its_time_in_seconds():
    found = parse(json.dumps(FRAME))
    assert (found.number, found.time, found.spin) == (7, 1.5, None)
    assert found.position.tolist() == [0.1, -0.2, 0.3]
    assert parse(json.dumps(FRAME | {"spin": [1, 2, 3]})).spin.tolist() == [1, 2, 3]
    assert parse(json.dumps(FRAME | {"obs": None})).position is None


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        (b"\xff", "is no JSON"),
        ("{", "is no JSON"),
        ("[1]", "is no JSON object"),
        (json.dumps(FRAME | {"time": "now"}), "time = 'now'"),
        (json.dumps(FRAME | {"num": True}), "num = True"),
        (json.dumps(FRAME | {"obs": [1, 2]}), r"obs = \[1, 2\]"),
        (json.dumps(FRAME | {"obs": [1, 2, None]}), "three finite numbers"),
    ],
)
def test_what_is_no_measurement_says_what_is_wrong(message, problem):
    with pytest.raises(MessageError, match=problem):
        parse(message)


def test_recordings_follow_one_another_on_one_clock():
    rows = pd.DataFrame(
        {"recording_id": ["a", "a", "b"], "t": [5.0, 5.1, 3.0], "px": 0.0, "py": 0.0, "pz": 0.3}
    ).assign(wx=[np.nan, 1.0, 2.0], wy=1.0, wz=1.0)
    found = list(measurements([rows]))
    assert [one.time for one in found] == pytest.approx([0.0, 0.1, 1.1])
    assert [one.spin is None for one in found] == [True, False, False]
    start = time.monotonic()
    assert list(paced(found, 11.0)) == found  # as fast as they were recorded, times 11
    assert time.monotonic() - start >= 0.1


def test_a_forecast_has_states_errors_the_bounce_and_the_alarm():
    forecaster = Forecaster(TRUTH)
    none = json.loads(forecast_message(0, "used", None))
    assert none["states"] is none["drift"] is None
    times = 2.0 + 0.005 * np.arange(30)
    for t, state in zip(times, TRUTH.fly(FIRST, times - 2.0).states[0], strict=True):
        forecaster.observe(t, state[:3])
    message = json.loads(forecast_message(29, "used", ball_forecast(forecaster), ALARM))
    assert message["drift"]["identity"] == "wind.x"
    assert message["time"] == round(times[-1] * 1e9)
    true = TRUTH.fly(FIRST, times[-1] - 2.0 + np.array(message["ahead"])).states[0]
    assert np.array(message["states"])[:, :3] == pytest.approx(true[:, :3], abs=0.05)
    assert np.shape(message["position_errors"]) == (30, 3)
    contact = TRUTH.fly(FIRST, np.arange(0.0, 1.0, 0.005)).contacts.time[0, 0]
    assert message["bounce"]["time"] == pytest.approx((2.0 + contact) * 1e9, abs=3e7)


def test_percentiles_are_right_to_a_hundredth_of_a_millisecond():
    seconds = np.random.default_rng(0).gamma(2.0, 2e-4, 10_000)
    latencies = Latencies()
    for one in seconds:
        latencies.add(one)
    for share in (50, 99, 99.9):
        assert latencies.percentile(share) == pytest.approx(
            1e3 * np.percentile(seconds, share), abs=0.011
        )


def test_the_histogram_has_every_frame():
    latencies = Latencies()
    for milliseconds in (0.05, 0.15, 0.15, 3.0, 80.0):
        latencies.add(milliseconds / 1e3)
    lines = latencies.histogram()
    counts = [int(line.split(" ms")[1].replace("and more", "").split()[0]) for line in lines]
    assert counts == [1, 2, 0, 0, 0, 0, 1, 0, 1]
    assert summary(latencies).startswith("5 frames")
    assert summary(Latencies()) == "no frame"
