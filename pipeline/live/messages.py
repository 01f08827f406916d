"""Measurements as they come, and messages of forecasts.

Measurements are those of tennicam's server by ZeroMQ, or of recordings as if from one.
"""

import json
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import typer
import zmq

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.state import POSITION
from rallygap.models.ball.types import Floats
from rallygap.models.live.drift import Alarm
from rallygap.models.live.forecaster import Event, Forecaster, Seen
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS
from rallygap.pipeline.runtime.errors import InputError

NANOSECONDS = 1e9  # in a second
WAIT = 200  # ms, after which signals are looked at
PAUSE = 1.0  # s on the clock between two recordings
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
    number, nanoseconds = _number(fields, "num"), _number(fields, "time")
    position, spin = _vector(fields, "obs"), _vector(fields, "spin")
    return Measurement(int(number), nanoseconds / NANOSECONDS, position, spin)


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


@contextmanager
def sockets(observations: str | None, forecasts: str) -> Iterator[tuple[zmq.Socket, zmq.Socket]]:
    """Open the socket that measurements come from, and the one that forecasts go to.

    Args:
        observations: address of a publisher; None to receive nothing.
        forecasts: address to publish at.

    Raises:
        InputError: an address cannot be used.
    """
    context = zmq.Context()
    receiver, sender = context.socket(zmq.SUB), context.socket(zmq.PUB)
    try:
        receiver.setsockopt(zmq.SUBSCRIBE, b"")
        # A signal just before a wait without end would be noticed with the next message only.
        receiver.setsockopt(zmq.RCVTIMEO, WAIT)
        if observations is not None:
            _open(receiver.connect, "--observations", observations)
        _open(sender.bind, "--forecasts", forecasts)
        yield receiver, sender
    finally:
        context.destroy(linger=0)


def received(receiver: zmq.Socket) -> Iterator[Measurement]:
    """Yield measurements as they come; a message that is none is named once and left out."""
    named = False
    while True:
        try:
            measurement = parse(receiver.recv())
        except zmq.Again:
            continue
        except MessageError as error:
            if not named:
                typer.echo(f"A message {error}; such messages are left out.", err=True)
            named = True
            continue
        yield measurement


def measurements(parts: Iterable[pd.DataFrame]) -> Iterator[Measurement]:
    """Yield the rows of recordings, one recording after the other on one clock.

    Args:
        parts: rows of ``RECORDINGS``, each with whole recordings.
    """
    number, now = 0, 0.0
    for part in parts:
        for _, rows in part.groupby("recording_id", sort=False):
            times = rows["t"].to_numpy(dtype=np.float64)
            times = now + times - times[0]
            positions = rows[POSITION_COLUMNS].to_numpy(dtype=np.float64)
            spins = rows[SPIN_COLUMNS].to_numpy(dtype=np.float64)
            for t, position, spin in zip(times.tolist(), positions, spins, strict=True):
                yield Measurement(number, t, position, spin if np.isfinite(spin).all() else None)
                number += 1
            now = float(times[-1]) + PAUSE


def paced(rows: Iterable[Measurement], speed: float) -> Iterator[Measurement]:
    """Yield measurements when they are due, ``speed`` times as fast as they were recorded."""
    zero = None  # when the recording's time zero is, on the clock of this process
    for row in rows:
        if zero is None:
            zero = time.monotonic() - row.time / speed
        time.sleep(max(zero + row.time / speed - time.monotonic(), 0.0))
        yield row


def _open(connect: Callable[[str], object], option: str, address: str) -> None:
    try:
        connect(address)
    except zmq.ZMQError as error:
        problem = f"cannot be used: {error}; give one like tcp://127.0.0.1:7660"
        raise InputError(option, problem, field=address) from None


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
        "drift": None,
    }
    if alarm is not None:
        message["drift"] = {
            "identity": alarm.hypothesis.identity,
            "change": alarm.change,
            "error": alarm.error,
            "possible": [hypothesis.identity for hypothesis in alarm.possible],
        }
    if ball is not None:
        errors, bounce = np.sqrt(ball.covariances[:, range(3), range(3)]), ball.bounce
        message |= {
            "time": round(ball.time * NANOSECONDS),
            "ahead": AHEAD.round(3).tolist(),
            "states": ball.states.round(5).tolist(),
            "position_errors": errors.round(5).tolist(),
            "bounce": None
            if bounce is None
            else {
                "time": round(bounce.time * NANOSECONDS),
                "time_error": round(bounce.time_error, 5),
                "state": bounce.state.round(5).tolist(),
            },
        }
    return json.dumps(message)


def alarm_sentence(alarm: Alarm) -> str:
    """Return an alarm in words."""
    hypothesis, unit = alarm.hypothesis, alarm.hypothesis.declaration.unit
    size = f"{alarm.change:+.3g}" + (f" {unit}" if unit != "1" else "")
    others = ", ".join(other.identity for other in alarm.possible[1:])
    tail = f" Not separable from {others}." if others else ""
    return (
        f"The world has left the simulator: {hypothesis.identity} "
        f"({catalogue()[hypothesis.effect].title}) has changed by {size} (standard error "
        f"{alarm.error:.2g}) in the last {alarm.shots} shots.{tail} Diagnose new recordings."
    )
