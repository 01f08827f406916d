"""Messages are those of tennicam's server; what is none says what is wrong."""

import json

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.live.forecaster import Forecaster
from rallygap.pipeline.live.messages import (
    MessageError,
    ball_forecast,
    forecast_message,
    parse,
)

TRUTH = shipped("literature")
FIRST = np.array([0.1, 1.2, 0.35, 0.3, -6.0, 1.0, -150.0, 20.0, 30.0])
FRAME = {"num": 7, "time": 1_500_000_000, "proc_time": 1, "obs": [0.1, -0.2, 0.3]}


def test_a_measurement_has_its_time_in_seconds():
    found = parse(json.dumps(FRAME))
    assert (found.number, found.time, found.spin) == (7, 1.5, None)
    assert found.position.tolist() == [0.1, -0.2, 0.3]
    assert parse(json.dumps(FRAME | {"spin": [1, 2, 3]})).spin.tolist() == [1, 2, 3]


def test_a_frame_without_a_ball_has_no_position():
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


def test_a_forecast_has_states_errors_and_the_bounce():
    forecaster = Forecaster(TRUTH)
    assert json.loads(forecast_message(0, "used", None))["states"] is None
    times = 2.0 + 0.005 * np.arange(30)
    for t, state in zip(times, TRUTH.fly(FIRST, times - 2.0).states[0], strict=True):
        forecaster.observe(t, state[:3])
    message = json.loads(forecast_message(29, "used", ball_forecast(forecaster)))
    assert message["time"] == round(times[-1] * 1e9)
    true = TRUTH.fly(FIRST, times[-1] - 2.0 + np.array(message["ahead"])).states[0]
    assert np.array(message["states"])[:, :3] == pytest.approx(true[:, :3], abs=0.05)
    assert np.shape(message["position_errors"]) == (30, 3)
    contact = TRUTH.fly(FIRST, np.arange(0.0, 1.0, 0.005)).contacts.time[0, 0]
    assert message["bounce"]["time"] == pytest.approx((2.0 + contact) * 1e9, abs=3e7)
