"""Replay: measured balls come to the robot as they came to whoever returned them.

What the robot meets is the ball's true path; what its predictor is told are the samples that were
measured, each when it was measured. A shot begins with its first sample, which is its launch, and
the control ticks begin ``FIRST_WINDOW`` later. Where the recording ends, because somebody struck
the ball or the cameras lost it, the ball flies on, and is measured on.

At each tick there is a history that ends with the latest sample, as in the windows that predictors
are evaluated on. It is some milliseconds old where samples do not fall on the ticks. What is
forecast from it lies that much further ahead; beyond the end of the forecast the ball stays where
that ends.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.ball.contact_laws import NONE, TABLE
from models.ball.simulator import Contacts, Flight, Simulator
from models.ball.state import POSITION, STATE_SIZE
from models.policy.incoming_balls import FIRST_WINDOW, PATH_STEP, PATH_TIMES, playable, tick_times
from models.policy.launches import WORKSPACE
from models.policy.outcome import with_net
from models.policy.settings import HorizonsMs
from models.predictors.physics import PhysicsPredictor
from models.predictors.protocol import FUTURE, HISTORY_TIMES, TICK, History, Predictor
from models.predictors.windows import MIN_OBSERVED, ROUNDING, Episode, observed_at
from models.replay.shots import Shot

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]

WINDOWS_AT_ONCE = 2048  # that a predictor is given, for the memory's sake


@dataclass(frozen=True)
class Views:
    """What predictors can tell the future of B balls from at each of T control ticks.

    Attributes:
        history: the S histories of all balls, ball by ball, in the order of time.
        latest: (B, T) at each tick, which of the histories is the latest of that ball.
        age: (B, T) s that have passed since that history ended.
    """

    history: History
    latest: Integers
    age: Floats

    @property
    def first(self) -> Integers:
        """(B,) which of the histories is the ball's first."""
        return self.latest[:, 0]


def fly_on(simulator: Simulator, shots: Sequence[Shot]) -> tuple[Floats, Floats]:
    """Return ``path`` and ``playable`` of an ``Incoming``: where B balls were, and went on to.

    A bounce on the far half, as serves have, comes before the ball can be played.

    Args:
        simulator: flies the balls on from where they are known last.
        shots: B.
    """
    ends = PATH_STEP * np.array([len(shot.known) - 1.0 for shot in shots])
    last = np.array([shot.known[-1] for shot in shots]).reshape(-1, STATE_SIZE)
    flight = with_net(simulator).fly(last, np.maximum(PATH_TIMES - ends[:, None], 0.0))
    path, later = flight.states, flight.contacts
    bounces = []
    for row, shot in enumerate(shots):
        path[row, : len(shot.known)] = shot.known
        more = later.time[row, later.surface[row] == TABLE] + ends[row]
        bounces.append(np.concatenate([shot.bounces, more]))
    return path, playable(Flight(path, _near_contacts(path, bounces)), PATH_TIMES)


def within_reach(path: Floats, playable: Floats) -> Booleans:
    """Return which (B,) balls come to where the racket strikes well, however fast, while they can.

    Args:
        path: (B, N, 9) as in ``Incoming``.
        playable: (B, 2) as in ``Incoming``.
    """
    places = path[..., POSITION]
    inside = ((WORKSPACE[:, 0] <= places) & (places <= WORKSPACE[:, 1])).all(axis=2)
    in_time = (playable[:, :1] < PATH_TIMES) & (playable[:, 1:] > PATH_TIMES)
    reached: Booleans = np.any(inside & in_time, axis=1)
    return reached


def views(shots: Sequence[Shot]) -> Views:
    """Return what was seen of balls at each of the control ticks.

    Args:
        shots: those that are ``seen_in_time``.
    """
    ticks = tick_times(FIRST_WINDOW)
    parts: list[History] = []
    latest, age, before = [], [], 0
    for shot in shots:
        ends, history = _histories(shot.measured)
        newest = np.searchsorted(ends, ticks + ROUNDING, side="right") - 1
        latest.append(before + newest)
        age.append(ticks - ends[newest])
        parts.append(history)
        before += len(history)
    states = np.concatenate([part.states for part in parts])
    masks = np.concatenate([part.mask for part in parts])
    return Views(History(states, masks), np.array(latest), np.array(age))


def seen_in_time(measured: Episode) -> bool:
    """Return whether a predictor has seen enough of a ball at the first control tick."""
    ends, _ = _histories(measured)
    return bool((ends <= FIRST_WINDOW + ROUNDING).any())


def predicted(predictor: Predictor, history: History) -> Floats:
    """Return the (S, 60, 9) forecasts from S histories."""
    starts = range(0, len(history), WINDOWS_AT_ONCE)
    parts = [history[start : start + WINDOWS_AT_ONCE] for start in starts]
    return np.concatenate([predictor.predict(part).states for part in parts])


def every_tick(forecasts: Floats, views: Views, horizons: HorizonsMs) -> Floats:
    """Return the ``forecasts`` of an ``Incoming`` where a predictor is asked at every tick.

    Args:
        forecasts: (S, 60, 9) from each of the histories, as ``predicted`` returns them.
        views: of B balls.
        horizons: ms.
    """
    ahead = (views.age[..., None] + np.array(horizons) / 1000) / TICK - 1
    place = np.minimum(ahead.round(6), FUTURE - 1)  # among the states of a forecast
    before = place.astype(np.int64)
    after, share = np.minimum(before + 1, FUTURE - 1), (place - before)[..., None]
    rows = views.latest[..., None]
    told: Floats = (1 - share) * forecasts[rows, before] + share * forecasts[rows, after]
    return told


def first_window(simulator: Simulator, views: Views, horizons: HorizonsMs) -> Floats:
    """Return the ``forecasts`` of an ``Incoming`` where the whole flight is forecast at once.

    A filter takes in the first window, and its simulator flies the ball on from there.
    """
    history = History(views.history.states[views.first], views.history.mask[views.first])
    soon = PhysicsPredictor(simulator).predict(history).states[:, 0]
    instants = tick_times(FIRST_WINDOW)[:, None] + np.array(horizons) / 1000
    times, places = np.unique(instants.round(9), return_inverse=True)
    known_at = FIRST_WINDOW - views.age[:, :1] + TICK
    flown = simulator.fly(soon, np.maximum(times - known_at, 0.0)).states
    return flown[:, places.reshape(instants.shape)]


def _histories(measured: Episode) -> tuple[Floats, History]:
    """Return when a ball's histories end, one for each tick with a new sample, and the histories.

    One with hardly a sample tells less than the one before, and is left out.
    """
    ticks = tick_times(FIRST_WINDOW)
    newest = np.searchsorted(measured.times, ticks + ROUNDING, side="right") - 1
    ends = measured.times[np.unique(newest)]
    seen = [observed_at(measured, end + HISTORY_TIMES, until=end) for end in ends]
    states, mask = (np.array(part) for part in zip(*seen, strict=True))
    enough = mask[..., POSITION].all(axis=2).sum(axis=1) >= MIN_OBSERVED
    return ends[enough], History(states[enough], mask[enough])


def _near_contacts(path: Floats, bounces: Sequence[Floats]) -> Contacts:
    """Return each ball's first bounce on the robot's half, and the one after it."""
    time = np.full((len(path), 2), np.nan)
    before, after = (np.zeros((len(path), 2, STATE_SIZE)) for _ in range(2))
    for row, times in enumerate(bounces):
        steps = np.minimum((times / PATH_STEP).astype(np.int64), path.shape[1] - 2)
        near = np.flatnonzero(path[row, steps, 1] < 0)[:1]
        kept = slice(near[0], near[0] + 2) if len(near) else slice(0, 0)
        count = len(times[kept])
        time[row, :count] = times[kept]
        before[row, :count], after[row, :count] = path[row, steps[kept]], path[row, steps[kept] + 1]
    there = ~np.isnan(time)
    return Contacts(there.sum(axis=1), time, np.where(there, TABLE, NONE), before, after)
