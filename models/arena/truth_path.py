"""The true paths of balls, simulated from their contacts, and what the cameras see of them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rallygap.models.arena.cameras import Cameras
from rallygap.models.arena.contacts import fly_to_contact
from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.truth import Truth
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats, Integers

ARCS_PER_BATCH = 256  # arcs flown at once; arcs of similar length share their padding
ROUNDING = 1e-9  # s


def true_states(truth: Truth, contacts: TrueContacts, times: Floats) -> Floats:
    """Return the (n, 9) true states at (n,) rising times, s.

    They are NaN before the first contact, and between the time when the ball leaves the view or has
    a contact that is not listed, and the next listed contact.
    """
    moments = np.asarray(times, dtype=np.float64)
    states = np.full((len(moments), STATE_SIZE), np.nan)
    arcs = np.searchsorted(contacts.times, moments, side="right") - 1
    elapsed = moments - contacts.times[arcs]
    ends = fly_to_contact(truth, contacts.states)
    known = elapsed <= np.minimum(ends.times, ends.lost)[arcs] + ROUNDING
    playing = (arcs >= 0) & known
    states[playing] = along_arcs(truth.simulator, contacts.states, arcs[playing], elapsed[playing])
    return states


def along_arcs(simulator: Simulator, starts: Floats, arcs: Integers, elapsed: Floats) -> Floats:
    """Return (n, 9) states along many arcs.

    Args:
        simulator: of the flight.
        starts: (A, 9) states at the arcs' starts.
        arcs: (n,) the arc of each moment, not falling.
        elapsed: (n,) s since the arc's start, not falling within an arc.
    """
    used, first, counts = np.unique(arcs, return_index=True, return_counts=True)
    states = np.empty((len(arcs), STATE_SIZE))
    by_length = np.argsort(counts, kind="stable")
    for start in range(0, len(used), ARCS_PER_BATCH):
        batch = by_length[start : start + ARCS_PER_BATCH]
        steps = np.arange(counts[batch].max())
        rows = first[batch, None] + np.minimum(steps, counts[batch, None] - 1)
        states[rows] = simulator.fly(starts[used[batch]], elapsed[rows]).states
    return states


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
    frames, arcs, elapsed, first = [], [], [], 0
    for ball in balls:
        start = np.ceil(ball.contacts.times[0] / cameras.interval)
        end = np.floor(ball.last_visible / cameras.interval) + 1
        times = np.arange(start, end) * cameras.interval
        arc = np.searchsorted(ball.contacts.times, times, side="right") - 1
        frames.append(times)
        arcs.append(first + arc)
        elapsed.append(times - ball.contacts.times[arc])
        first += len(ball.contacts.times)
    starts = np.concatenate([ball.contacts.states for ball in balls])
    paths = along_arcs(truth.simulator, starts, np.concatenate(arcs), np.concatenate(elapsed))
    borders = np.cumsum([len(times) for times in frames])[:-1]
    for times, path, arc in zip(frames, np.split(paths, borders), arcs, strict=True):
        positions, spins, exists = cameras.measure(path, random, arc)
        yield times[exists], positions[exists], spins[exists]
