"""Messages: measurements as tennicam's server sends them, and forecasts."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from rallygap.models.ball.state import POSITION
from rallygap.models.ball.types import Floats
from rallygap.models.live.drift import Alarm
from rallygap.models.live.forecaster import Event, Forecaster, Seen

NANOSECONDS = 1e9  # in a second
AHEAD = 0.01 * np.arange(1, 31)  # s after the last measurement, of the states in a forecast


class MessageError(ValueError):
    """A message is no measurement."""


@dataclass(frozen=True)
class Measurement:
    """A measurement of a ball.

    Attributes:
        number: of the frame.
        time: s, of the sensor's clock.
        position: (3,) m; None if the frame shows no ball.
        spin: (3,) rad/s, if it was measured.
    """

    number: int
    time: float
    position: Floats | None
    spin: Floats | None = None


@dataclass(frozen=True)
class BallForecast:
    """Where a ball will be.

    Attributes:
        time: s, of its last measurement, on the sensor's clock.
        states: (30, 9) position (m), velocity (m/s) and spin (rad/s), ``AHEAD`` of that time.
        covariances: (30, 3, 3) m^2, of the positions.
        bounce: the next contact with the table; None without any.
    """

    time: float
    states: Floats
    covariances: Floats
    bounce: Event | None


def parse(message: bytes | str) -> Measurement:
    """Return the measurement in a message.

    It is the JSON of https://github.com/intelligent-soft-robots/tennicam_client: ``num``, ``time``
    in ns, ``obs``, a position in m or null; and where spin is measured, ``spin`` in rad/s.

    Raises:
        MessageError: saying what is wrong.
    """
    try:
        fields = json.loads(message)
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise MessageError(f"is no JSON: {error}") from None
    if not isinstance(fields, dict):
        raise MessageError("is no JSON object with num, time and obs")
    number, time = _number(fields, "num"), _number(fields, "time")
    position, spin = _vector(fields, "obs"), _vector(fields, "spin")
    return Measurement(int(number), time / NANOSECONDS, position, spin)


def _number(fields: dict[str, Any], name: str) -> float:
    value = fields.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise MessageError(f"has {name} = {value!r}; give a number")
    return value


def _vector(fields: dict[str, Any], name: str) -> Floats | None:
    value = fields.get(name)
    if value is None:
        return None
    try:
        vector = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        vector = np.empty(0)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise MessageError(f"has {name} = {value!r}; give three finite numbers, or null")
    return vector


def ball_forecast(forecaster: Forecaster) -> BallForecast | None:
    """Return the forecast of the present ball; None without a ball."""
    if not forecaster.ready:
        return None
    states, covariances = forecaster.predict(forecaster.last + AHEAD)
    of_positions = covariances[:, POSITION, POSITION]
    return BallForecast(forecaster.last, states, of_positions, forecaster.bounce())


def forecast_message(
    number: int, seen: Seen, ball: BallForecast | None, alarm: Alarm | None = None
) -> str:
    """Return the forecast after a frame as JSON; its states are null without a ball.

    Args:
        number: of the frame.
        seen: what became of its measurement.
        ball: the forecast; None without a ball.
        alarm: of the watch for drift, if there was one.
    """
    message: dict[str, Any] = {
        "num": number,
        "seen": seen,
        "time": None,
        "states": None,
        "drift": _drift(alarm),
    }
    if ball is not None:
        errors = np.sqrt(ball.covariances[:, range(3), range(3)])
        message |= {
            "time": _nanoseconds(ball.time),
            "ahead": AHEAD.round(3).tolist(),
            "states": ball.states.round(5).tolist(),
            "position_errors": errors.round(5).tolist(),
            "bounce": _event(ball.bounce),
        }
    return json.dumps(message)


def _drift(alarm: Alarm | None) -> dict[str, Any] | None:
    if alarm is None:
        return None
    return {
        "identity": alarm.hypothesis.identity,
        "change": alarm.change,
        "error": alarm.error,
        "possible": [hypothesis.identity for hypothesis in alarm.possible],
    }


def _event(event: Event | None) -> dict[str, Any] | None:
    if event is None:
        return None
    return {
        "time": _nanoseconds(event.time),
        "time_error": round(event.time_error, 5),
        "state": event.state.round(5).tolist(),
    }


def _nanoseconds(time: float) -> int:
    return round(time * NANOSECONDS)
