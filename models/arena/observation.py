"""Camera samples of balls, from their true contacts."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rallygap.models.arena.cameras import Cameras
from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.truth import Truth
from rallygap.models.arena.truth_path import along_arcs
from rallygap.models.ball.types import Floats


@dataclass(frozen=True)
class TrackedBall:
    """One ball from its launch until the cameras lose it."""

    contacts: TrueContacts  # its launch and all contacts after it
    last_visible: float  # s, time of the last possible sample


def observe(
    truth: Truth, cameras: Cameras, balls: Sequence[TrackedBall], random: np.random.Generator
) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Yield times (n,) s, positions (n, 3) m and spins (n, 3) rad/s of each ball's samples.

    Samples lie at multiples of the cameras' interval.
    """
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
    for times, path, arc in zip(frames, np.split(paths, borders), arcs, strict=True):
        positions, spins, exists = cameras.measure(path, random, arc)
        yield times[exists], positions[exists], spins[exists]


def _frames(ball: TrackedBall, interval: float) -> Floats:
    """Return the times of the frames between launch and last visibility."""
    first = np.ceil(ball.contacts.times[0] / interval)
    return np.arange(first, np.floor(ball.last_visible / interval) + 1) * interval
