"""The bridge to a camera server and to a robot: ZeroMQ sockets."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import typer
import zmq

from rallygap.pipeline.live.messages import Measurement, MessageError, parse
from rallygap.pipeline.runtime.errors import InputError

WAIT = 200  # ms, after which signals are looked at


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


def _opened(connect: Callable[[str], object], option: str, address: str) -> None:
    try:
        connect(address)
    except zmq.ZMQError as error:
        problem = f"cannot be used: {error}; give one like tcp://127.0.0.1:7660"
        raise InputError(option, problem, field=address) from None
