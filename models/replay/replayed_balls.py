"""Replay of measured shots: their true paths, and forecasts from their measurements.

The racket meets the ball's true path; the predictor gets the measured samples, each when it was
measured. A shot starts with its first sample, which counts as the launch; control steps start
``FIRST_WINDOW`` later. After the recording ends, because a player struck the ball or the cameras
lost it, a simulator flies the ball on, and its measurements are simulated.

At each control step the history ends with the latest sample, as in the windows that predictors are
evaluated on. Where samples do not fall on control steps, the history is some milliseconds old, and
the forecast is read that much farther ahead; beyond its end the last forecast state is used.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rallygap.models.ball.contact_laws import NONE, TABLE
from rallygap.models.ball.simulator import Contacts, Flight, Simulator
from rallygap.models.ball.state import POSITION, SPIN, STATE_SIZE
from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.policy.incoming_balls import (
    FIRST_WINDOW,
    PATH_STEP,
    PATH_TIMES,
    control_times,
    playable,
)
from rallygap.models.policy.launches import WORKSPACE
from rallygap.models.policy.outcome import with_net
from rallygap.models.policy.settings import HorizonsMs
from rallygap.models.predictors.long_forecast import between_ticks, forecast_at
from rallygap.models.predictors.protocol import (
    HISTORY_TIMES,
    History,
    Predictor,
    ProbabilisticPredictor,
    concatenate_histories,
)
from rallygap.models.predictors.windows import MIN_OBSERVED, ROUNDING, Episode, observed_at
from rallygap.models.replay.shots import Shot

BATCH = 2048  # histories per call of a predictor, which bounds its memory


@dataclass(frozen=True)
class Histories:
    """The measurement histories of B balls at T control steps.

    Attributes:
        history: all S histories, ball by ball, in the order of time.
        latest: (B, T) at each control step, the index of the ball's latest history.
        age: (B, T) s since that history ended.
    """

    history: History
    latest: Integers
    age: Floats

    @property
    def first(self) -> Integers:
        """(B,) index of each ball's first history."""
        return self.latest[:, 0]


def fly_on(simulator: Simulator, shots: Sequence[Shot]) -> tuple[Floats, Floats]:
    """Return ``path`` and ``playable`` of ``IncomingBalls`` for B shots.

    A bounce on the far half, as in serves, comes before the ball can be played.

    Args:
        simulator: flies the balls on from the ends of their known paths.
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


def reachable(path: Floats, playable: Floats) -> Bools:
    """Return which (B,) balls pass through the racket's workspace while they can be played.

    Args:
        path: (B, N, 9) as in ``IncomingBalls``.
        playable: (B, 2) as in ``IncomingBalls``.
    """
    positions = path[..., POSITION]
    inside = ((WORKSPACE[:, 0] <= positions) & (positions <= WORKSPACE[:, 1])).all(axis=2)
    in_time = (playable[:, :1] < PATH_TIMES) & (playable[:, 1:] > PATH_TIMES)
    return np.any(inside & in_time, axis=1)


def measurement_histories(shots: Sequence[Shot]) -> Histories:
    """Return the measurement histories of shots at the control steps.

    Args:
        shots: those that are ``measured_in_time``.
    """
    steps = control_times(FIRST_WINDOW)
    parts: list[History] = []
    latest, age, before = [], [], 0
    for shot in shots:
        ends, history = _histories(shot.measured)
        newest = np.searchsorted(ends, steps + ROUNDING, side="right") - 1
        latest.append(before + newest)
        age.append(steps - ends[newest])
        parts.append(history)
        before += len(history)
    return Histories(concatenate_histories(parts), np.array(latest), np.array(age))


def measured_in_time(measured: Episode) -> bool:
    """Return whether there are enough samples for a forecast at the first control step."""
    ends, _ = _histories(measured)
    return bool((ends <= FIRST_WINDOW + ROUNDING).any())


def predict_all(predictor: Predictor, history: History) -> Floats:
    """Return the (S, 60, 9) forecasts from S histories."""
    parts = [history[first : first + BATCH] for first in range(0, len(history), BATCH)]
    return np.concatenate([predictor.predict(part).states for part in parts])


def predict_all_with_spreads(
    predictor: ProbabilisticPredictor, history: History
) -> tuple[Floats, Floats]:
    """Return the (S, 60, 9) forecasts and (S, 60, 3) m, standard deviations of their positions."""
    states, spreads = [], []
    for first in range(0, len(history), BATCH):
        forecast, covariances = predictor.predict_with_covariances(history[first : first + BATCH])
        states.append(forecast.states)
        spreads.append(np.sqrt(np.diagonal(covariances, axis1=2, axis2=3)))
    return np.concatenate(states), np.concatenate(spreads)


def every_step(forecasts: Floats, histories: Histories, horizons: HorizonsMs) -> Floats:
    """Return the ``forecasts`` of ``IncomingBalls`` from the latest history at every control step.

    Or its ``spreads``, from (S, 60, 3) of these.

    Args:
        forecasts: (S, 60, 9) from each history, as ``predict_all`` returns them.
        histories: of B balls.
        horizons: ms.
    """
    ahead = histories.age[..., None] + np.array(horizons) / 1000
    return between_ticks(forecasts, histories.latest[..., None], ahead)


def anchored(
    predictor: Predictor, histories: Histories, horizons: HorizonsMs, every: int | None = None
) -> Floats:
    """Return the ``forecasts`` of ``IncomingBalls`` from some of the histories alone.

    Args:
        predictor: forecasts.
        histories: of B balls.
        horizons: ms.
        every: control steps from one forecast to the next; without it all is forecast from the
            first window.
    """
    steps = control_times(FIRST_WINDOW)
    states = np.empty((*histories.latest.shape, len(horizons), STATE_SIZE))
    for first in range(0, len(steps), every or len(steps)):
        served = slice(first, first + (every or len(steps)))
        wanted = steps[served, None] - steps[first] + np.array(horizons) / 1000
        times, indices = np.unique(wanted.round(9), return_inverse=True)
        rows = histories.latest[:, first]
        history = History(histories.history.states[rows], histories.history.mask[rows])
        forecast = forecast_at(predictor, history, histories.age[:, first, None] + times)
        states[:, served] = forecast[:, indices.reshape(wanted.shape)]
    return states


def with_label_error(histories: Histories, share: float, random: np.random.Generator) -> Histories:
    """Return histories whose spin labels have an error, the same in all labels of a ball.

    Args:
        histories: of B balls.
        share: standard deviation of a component, in shares of the ball's mean spin.
        random: of the errors.
    """
    history, balls = histories.history, len(histories.latest)
    ball = np.searchsorted(histories.first, np.arange(len(history)), side="right") - 1
    labelled = history.mask[..., 3:].all(axis=2)
    sizes = np.where(labelled, np.linalg.norm(history.states[..., 3:], axis=2), 0.0)
    total = np.bincount(ball, sizes.sum(axis=1), balls)
    mean = total / np.maximum(np.bincount(ball, labelled.sum(axis=1), balls), 1)
    errors = share * mean[:, None] * random.standard_normal((balls, 3))
    states = history.states.copy()
    states[..., 3:] += np.where(history.mask[..., 3:], errors[ball, None], 0.0)
    return replace(histories, history=History(states, history.mask))


def _histories(measured: Episode) -> tuple[Floats, History]:
    """Return a ball's histories, one per control step with a new sample, after their end times (s).

    Histories with fewer than ``MIN_OBSERVED`` positions are left out.
    """
    steps = control_times(FIRST_WINDOW)
    newest = np.searchsorted(measured.times, steps + ROUNDING, side="right") - 1
    ends = measured.times[np.unique(newest)]
    windows = [observed_at(measured, end + HISTORY_TIMES, until=end) for end in ends]
    states, mask = (np.array(part) for part in zip(*windows, strict=True))
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


def perturbed(forecasts: Floats, error: str, size: float, random: np.random.Generator) -> Floats:
    """Return forecasts with a deliberate error, to measure which errors a policy tolerates.

    Args:
        forecasts: (B, T, H, 9) as in ``IncomingBalls``.
        error: ``bias``, in one random direction per ball; ``noise``, independent per control step,
            whose horizons share one measurement window; or ``no_spin``.
        size: m, of a bias, or root mean square of the noise.
        random: of the directions, uniform on the sphere, and of the noise.
    """
    changed = forecasts.copy()
    if error == "no_spin":
        changed[..., SPIN] = 0.0
    elif error == "bias":
        drawn = random.standard_normal((len(forecasts), 1, 1, 3))
        changed[..., POSITION] += size * drawn / np.linalg.norm(drawn, axis=-1, keepdims=True)
    else:
        drawn = random.standard_normal((*forecasts.shape[:2], 1, 3))
        changed[..., POSITION] += size / np.sqrt(3) * drawn
    return changed
