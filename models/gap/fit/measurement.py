"""Measurement model: what a simulator's sensor measures of B balls, and its derivatives.

The nuisance parameters of a shot are its state ``[p v w]`` at its first sample and a *kick* at each
of its first K bounces (trajectory.py). Derivatives are finite differences of exact flights.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.sensor import (
    clock_times,
    delays,
    in_rising_order,
    measured_positions,
    measured_spins,
    true_times,
)
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN, STATE_SIZE, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.fit.trajectory import fly_with_kicks
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.types import Bools, Indices

# Samples so near a bounce, in s, are not used, since derivatives have a kink there; labels neither,
# since the spin jumps.
KINK = 2e-4
JUMP = 5e-3
# Steps for differences: m, m/s, rad/s, and kicks in units of the impact's normal speed. Paths are
# so nearly linear in these that one-sided differences are good to five digits.
STATE_STEPS = np.repeat([1e-5, 1e-4, 0.02], 3)
KICK_STEP = 1e-4


@dataclass(frozen=True)
class Schedule:
    """When B balls are measured, in s from each shot's first sample.

    Attributes:
        times: (B, T) of samples and labels together, not falling.
        samples: (B, N) places of the samples in ``times``.
        labels: (B, L) places of the labels; any place where there is no label.
        all_samples: whether all times are those of the samples, in their order.
        all_labels: the same of labels.
    """

    times: Floats
    samples: Indices
    labels: Indices
    all_samples: bool
    all_labels: bool

    @classmethod
    def of(cls, shots: Shots) -> "Schedule":
        """Return the schedule of measured shots."""
        start = shots.times[:, :1]
        labels = np.where(shots.labelled, shots.label_times, start) - start
        samples = shots.times - start
        unions = [np.union1d(s, w) for s, w in zip(samples, labels, strict=True)]
        longest = max(len(union) for union in unions)
        times = np.array([np.pad(u, (0, longest - len(u)), mode="edge") for u in unions])
        places = np.array([np.searchsorted(u, s) for u, s in zip(unions, samples, strict=True)])
        if np.array_equal(times, samples):
            places = np.tile(np.arange(longest), (len(times), 1))
        found = [np.searchsorted(u, w) for u, w in zip(unions, labels, strict=True)]
        spins = np.array(found, dtype=np.int64).reshape(labels.shape)
        if spins.shape == times.shape:
            spins = np.where(shots.labelled, spins, np.arange(longest))
        return cls(times, places, spins, *(_in_order(one, longest) for one in (places, spins)))

    @classmethod
    def of_times(cls, times: Floats) -> "Schedule":
        """Return the schedule of samples and labels at all of (B, T) times."""
        places = np.broadcast_to(np.arange(times.shape[1]), times.shape)
        return cls(times, places, places, all_samples=True, all_labels=True)

    def at_samples(self, rows: Floats) -> Floats:
        """Return (B, N, ...) those of (B, T, ...) rows that belong to samples."""
        return rows if self.all_samples else _rows_at(rows, self.samples)

    def at_labels(self, rows: Floats) -> Floats:
        """Return (B, L, ...) those of (B, T, ...) rows that belong to labels."""
        return rows if self.all_labels else _rows_at(rows, self.labels)

    def __getitem__(self, rows: Indices) -> "Schedule":
        return self._with(lambda array: array[rows])

    def repeated(self, count: int) -> "Schedule":
        """Return ``count`` copies of each ball's, one after the other."""
        return self._with(lambda array: np.repeat(array, count, axis=0))

    def _with(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> "Schedule":
        times, samples, labels = (change(one) for one in (self.times, self.samples, self.labels))
        return replace(self, times=times, samples=samples, labels=labels)


def _in_order(places: Indices, count: int) -> bool:
    return places.shape[1] == count and bool((places == np.arange(count)).all())


def _rows_at(rows: Floats, places: Indices) -> Floats:
    found: Floats = rows[np.arange(len(rows))[:, None], places]
    return found


@dataclass(frozen=True)
class Prediction:
    """Measurements of B balls, or their derivatives by each of C columns.

    Attributes:
        positions: (B, N, 3) m, or (B, N, 3, C).
        labels: (B, L, 3) rad/s, or (B, L, 3, C).
        velocities: (B, N, 3) of the balls, m/s.
        contacts: (B, M) times of contacts, s from the first sample, else NaN.
        smooth_until: (B,) time of the first contact with an edge or the net, beyond which
            derivatives mean nothing; NaN if never.
    """

    positions: Floats
    labels: Floats
    velocities: Floats
    contacts: Floats
    smooth_until: Floats

    def arcs(self, times: Floats) -> Indices:
        """Return (B, T) how many contacts are before each of (B, T) times."""
        before: Indices = (times[..., None] > self.contacts[:, None]).sum(axis=-1)
        return before

    def is_smooth(self, times: Floats, least: float) -> Bools:
        """Return which of (B, T) times are ``least`` from any contact and before the end."""
        near = np.abs(times[..., None] - self.contacts[:, None]) < least
        return np.logical_not(near.any(axis=-1) | (times > self.smooth_until[:, None] - least))


def count_bounces(simulator: Simulator, schedule: Schedule, nuisance: Floats) -> NDArray[np.int64]:
    """Return (B,) how often each ball bounces off the table before its last time."""
    flight = simulator.fly(nuisance[:, :STATE_SIZE], schedule.times)
    count: NDArray[np.int64] = (flight.contacts.surface == TABLE).sum(axis=1)
    return count


def predict_measurements(simulator: Simulator, schedule: Schedule, nuisance: Floats) -> Prediction:
    """Predict what a simulator's sensor measures, without noise; signs of labels are left alone.

    The nuisance parameters are (B, 9 + 3 K): states at the first sample, and kicks.
    """
    times = true_times(simulator, schedule.times)
    states, contacts, smooth_until = fly_with_kicks(simulator, nuisance, times)
    spins = schedule.at_labels(states[..., SPIN])
    velocities = schedule.at_samples(states[..., VELOCITY])
    delay = delays(simulator, np.sqrt(np.einsum("bni,bni->bn", velocities, velocities)))
    places = schedule.at_samples(states[..., POSITION])
    if np.any(delay):
        sampled = schedule.at_samples(times) - delay
        flown = in_rising_order(lambda at: fly_with_kicks(simulator, nuisance, at)[0], sampled)
        places = flown[..., POSITION]
    return Prediction(
        measured_positions(simulator, places),
        measured_spins(simulator, spins),
        velocities,
        clock_times(simulator, contacts),
        clock_times(simulator, smooth_until),
    )


def nuisance_derivatives(
    simulator: Simulator, schedule: Schedule, nuisance: Floats, prediction: Prediction
) -> Prediction:
    """Return the derivatives of a prediction by each of a shot's 9 + 3 K nuisance parameters."""
    size = nuisance.shape[1]
    steps = np.concatenate([STATE_STEPS, np.full(size - STATE_SIZE, KICK_STEP)])
    shifted = (nuisance[:, None] + np.diag(steps)).reshape(-1, size)
    ahead = predict_measurements(simulator, schedule.repeated(size), shifted)

    def differences(there: Floats, here: Floats) -> Floats:
        change = there.reshape(len(here), size, *here.shape[1:]) - here[:, None]
        slopes: Floats = np.moveaxis(change, 1, -1) / steps
        return slopes

    contacts = np.swapaxes(ahead.contacts.reshape(len(nuisance), size, -1), 0, 1)
    return Prediction(
        differences(ahead.positions, prediction.positions),
        differences(ahead.labels, prediction.labels),
        prediction.velocities,
        prediction.contacts,
        _smooth_until(prediction, *contacts),
    )


def hypothesis_derivatives(
    simulator: Simulator,
    schedule: Schedule,
    nuisance: Floats,
    prediction: Prediction,
    columns: tuple[Hypothesis, ...],
) -> Prediction:
    """Return the derivatives of a prediction by each of the C ``columns``."""
    positions = np.zeros((*prediction.positions.shape, len(columns)))
    labels = np.zeros((*prediction.labels.shape, len(columns)))
    contacts = []
    for column, hypothesis in enumerate(columns):
        value, other = hypothesis.value(simulator), hypothesis.nearby(simulator)
        there = predict_measurements(hypothesis.at(simulator, other), schedule, nuisance)
        positions[..., column] = (there.positions - prediction.positions) / (other - value)
        labels[..., column] = (there.labels - prediction.labels) / (other - value)
        contacts.append(there.contacts)
    smooth_until = _smooth_until(prediction, *contacts)
    return Prediction(positions, labels, prediction.velocities, prediction.contacts, smooth_until)


def _smooth_until(prediction: Prediction, *others: Floats) -> Floats:
    """Return until when derivatives hold: to the first contact if numbers of contacts differ."""
    smooth_until = prediction.smooth_until
    nothing = np.full((len(smooth_until), 1), np.nan)
    for contacts in others:
        more = np.isfinite(contacts).sum(axis=1) != np.isfinite(prediction.contacts).sum(axis=1)
        first = np.fmin.reduce(np.hstack([prediction.contacts, contacts, nothing]), axis=1)
        smooth_until = np.fmin(smooth_until, np.where(more, first, np.nan))
    return smooth_until
