"""Camera samples of balls, from their true contacts."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.arena.cameras import Cameras
from models.arena.recording import TrueContacts
from models.arena.truth import Truth
from models.arena.truth_path import along_arcs

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class TrackedBall:
    """One ball from its launch until the cameras lose it.

    Attributes:
        contacts: its launch and all contacts after it.
        last_visible: time of the last possible sample (s, on the clock of the contacts).
    """

    contacts: TrueContacts
    last_visible: float


@dataclass(frozen=True)
class Samples:
    """The samples of one ball: times (n,) in s, positions (n, 3) in m, spins (n, 3) in rad/s."""

    times: Floats
    positions: Floats
    spins: Floats


def observe(
    truth: Truth, cameras: Cameras, balls: Sequence[TrackedBall], random: np.random.Generator
) -> Iterator[Samples]:
    """Measure balls at multiples of the cameras' interval."""
    frames = [_frames(ball, cameras.interval) for ball in balls]
    arcs, elapsed, first = [], [], 0
    for ball, times in zip(balls, frames, strict=True):
        arc = np.searchsorted(ball.contacts.times, times, side="right") - 1
        arcs.append(first + arc)
        elapsed.append(times - ball.contacts.times[arc])
        first += len(ball.contacts.times)
    starts = np.concatenate([ball.contacts.states for ball in balls])
    paths = along_arcs(truth.simulator, starts, np.concatenate(arcs), np.concatenate(elapsed))
    borders = np.cumsum([len(times) for times in frames])[:-1]
    for times, path in zip(frames, np.split(paths, borders), strict=True):
        positions, spins, exists = cameras.measure(path, random)
        yield Samples(times[exists], positions[exists], spins[exists])


def _frames(ball: TrackedBall, interval: float) -> Floats:
    """Return the times of the frames between launch and last visibility."""
    first = np.ceil(ball.contacts.times[0] / interval)
    return np.arange(first, np.floor(ball.last_visible / interval) + 1) * interval
