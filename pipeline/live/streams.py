"""Measurements as they come: from a camera server by ZeroMQ, or from recordings as if from one."""

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

import numpy as np
import pandas as pd
import typer
import zmq

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS
from rallygap.pipeline.live.messages import Measurement, MessageError, parse
from rallygap.pipeline.runtime.errors import InputError

WAIT = 200  # ms, after which signals are looked at
PAUSE = 1.0  # s on the clock between two recordings


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
            _opened(receiver.connect, "--observations", observations)
        _opened(sender.bind, "--forecasts", forecasts)
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
            places = rows[POSITION_COLUMNS].to_numpy(dtype=np.float64)
            spins = rows[SPIN_COLUMNS].to_numpy(dtype=np.float64)
            for t, place, spin in zip(times.tolist(), places, spins, strict=True):
                yield Measurement(number, t, place, spin if np.isfinite(spin).all() else None)
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


def _opened(connect: Callable[[str], object], option: str, address: str) -> None:
    try:
        connect(address)
    except zmq.ZMQError as error:
        problem = f"cannot be used: {error}; give one like tcp://127.0.0.1:7660"
        raise InputError(option, problem, field=address) from None
