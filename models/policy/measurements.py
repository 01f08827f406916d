"""Measurements: the ball at 200 Hz as cameras see it, and the histories that predictors get."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.ball.state import POSITION, SPIN
from models.policy.incoming import FIRST_WINDOW, PATH_STEP, tick_times
from models.policy.incoming import TICK as CONTROL_TICK
from models.policy.settings import SensorNoise
from models.predictors.protocol import HISTORY, TICK, History
from models.predictors.windows import ROUNDING

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]

_PATH_STEPS = round(TICK / PATH_STEP)  # between two measurements
_BETWEEN_TICKS = round(CONTROL_TICK / TICK)  # measurements from one control tick to the next


@dataclass(frozen=True)
class Measurements:
    """What was measured of B balls, 5 ms apart.

    Attributes:
        states: (B, M, 6) positions (m) and spins (rad/s), the first at the launch; zero where not
            measured.
        mask: (B, M, 6) True where measured.
    """

    states: Floats
    mask: Booleans


@dataclass(frozen=True)
class Sightings:
    """What predictors can tell the future from at each control tick.

    The first tick is when the first 12 measurements are complete. A ball is seen anew at every tick
    until the cameras have lost it; then there is only what was seen before.

    Attributes:
        history: the S histories of all balls, ball by ball, in the order of their ticks.
        latest: (B, T) at each tick, which of the histories is the latest of that ball.
        age: (B, T) measurements that would have been made since.
    """

    history: History
    latest: Integers
    age: Integers


def measure(
    path: Floats, until: Floats, noise: SensorNoise, random: np.random.Generator
) -> Measurements:
    """Measure balls.

    Args:
        path: (B, N, 9) true states as in ``Incoming``.
        until: (B,) s from the launch, after which a ball is not seen any more.
        noise: of every measurement.
        random: where the noise comes from.
    """
    true = path[:, ::_PATH_STEPS]
    shape = (*true.shape[:2], 3)
    size = np.linalg.norm(true[..., SPIN], axis=2, keepdims=True)
    positions = true[..., POSITION] + noise.position * random.standard_normal(shape)
    spins = true[..., SPIN] + noise.spin * size * random.standard_normal(shape)
    seen = TICK * np.arange(true.shape[1]) <= until[:, None] + ROUNDING
    mask = np.repeat(seen[..., None], 6, axis=2)
    return Measurements(np.where(mask, np.concatenate([positions, spins], axis=2), 0.0), mask)


def sightings(measurements: Measurements) -> Sightings:
    """Return what was seen of balls at each of the control ticks.

    A ball that is lost before its first window is complete has that window all the same, with
    nothing measured at its end.
    """
    ticks = np.arange(len(tick_times(FIRST_WINDOW)))
    placed: Booleans = np.all(measurements.mask[..., POSITION], axis=2)
    measured = np.max(placed * np.arange(1, placed.shape[1] + 1), axis=1)  # until the last one
    newest = np.maximum((measured - HISTORY) // _BETWEEN_TICKS, 0)
    latest = np.minimum(ticks, np.minimum(newest, ticks[-1])[:, None])
    balls, windows = np.nonzero(latest == ticks)
    before = np.searchsorted(balls, np.arange(len(placed)))
    return Sightings(
        _histories(measurements, balls, windows * _BETWEEN_TICKS),
        before[:, None] + latest,
        (ticks - latest) * _BETWEEN_TICKS,
    )


def first_sight(measurements: Measurements) -> History:
    """Return the (B,) histories of the first 12 measurements."""
    balls = np.arange(len(measurements.states))
    return _histories(measurements, balls, np.zeros_like(balls))


def _histories(measurements: Measurements, balls: Integers, first: Integers) -> History:
    """Return the histories of ``balls`` that begin at their measurements ``first``."""
    missing = max(HISTORY + int(first.max(initial=0)) - measurements.states.shape[1], 0)
    padding = ((0, 0), (0, missing), (0, 0))
    states, mask = (np.pad(part, padding) for part in (measurements.states, measurements.mask))
    places = (balls[:, None], first[:, None] + np.arange(HISTORY))
    return History(states[places], mask[places])
