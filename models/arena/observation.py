"""From true contacts to recordings: the paths between them, as the cameras measure them."""

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
class Ball:
    """One ball from its launch until the cameras lose it.

    Attributes:
        contacts: all that changed it, its launch first.
        gone: when it is seen for the last time (s, on the clock of the contacts).
    """

    contacts: TrueContacts
    gone: float


@dataclass(frozen=True)
class Samples:
    """What the cameras measured of one ball: times (n,), positions and spins (n, 3)."""

    times: Floats
    positions: Floats
    spins: Floats


def observe(
    truth: Truth, cameras: Cameras, balls: Sequence[Ball], random: np.random.Generator
) -> Iterator[Samples]:
    """Measure balls with cameras whose frames fall at multiples of their interval."""
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
        positions, spins, seen = cameras.measure(path, random)
        yield Samples(times[seen], positions[seen], spins[seen])


def _frames(ball: Ball, interval: float) -> Floats:
    """Return the times of the frames that show a ball, none of them just before its launch."""
    first = np.ceil(ball.contacts.times[0] / interval)
    return np.arange(first, np.floor(ball.gone / interval) + 1) * interval
