"""Motion: what a simulator's sensor sees of B balls, and how that depends on every unknown.

A shot's unknowns ("nuisance") are its state ``[p v w]`` at its first sample and a *kick* at each of
its first K bounces (path.py). Derivatives are differences of exact flights, all unknowns of all
shots flown in one call.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from models.ball.contact_laws import TABLE
from models.ball.quantities import View
from models.ball.sensor import sensor_quantity
from models.ball.simulator import Simulator
from models.ball.state import POSITION, SPIN, STATE_SIZE, VELOCITY
from models.ball.types import Floats
from models.gap.fit.shots import Shots
from models.gap.fit.trajectory import path, path_in_any_order
from models.gap.hypotheses import Hypothesis
from models.gap.types import Bools, Indices

# So near a bounce, in s, that a sample is not used, since its derivatives have a kink there; and a
# label, since its spin is another one just before and just after.
KINK = 2e-4
JUMP = 5e-3
# Steps for differences: m, m/s, rad/s, and kicks in units of the impact's normal speed. Paths are
# so nearly linear in the unknowns that one-sided differences are good to five digits.
STATE_STEPS = np.repeat([1e-5, 1e-4, 0.02], 3)
KICK_STEP = 1e-4
LATEST = 1.0  # s that a sensor may be late, where values that are tried make a ball ever faster


@dataclass(frozen=True)
class Moments:
    """When B balls are looked at, in s from each shot's first sample.

    Attributes:
        times: (B, T) of samples and labels together, not falling.
        samples: (B, N) places of the samples in ``times``.
        labels: (B, L) places of the labels; any place where there is no label.
    """

    times: Floats
    samples: Indices
    labels: Indices

    @classmethod
    def of(cls, shots: Shots) -> "Moments":
        """Return the moments of measured shots."""
        start = shots.times[:, :1]
        labels = np.where(shots.labelled, shots.label_times, start) - start
        samples = shots.times - start
        if _at_samples(shots):
            places = np.arange(samples.shape[1])
            own = np.where(shots.labelled, places[: labels.shape[1]], 0)
            return cls(samples, np.tile(places, (len(samples), 1)), own)
        unions = [np.union1d(s, w) for s, w in zip(samples, labels, strict=True)]
        longest = max(len(union) for union in unions)
        times = np.array([np.pad(one, (0, longest - len(one)), mode="edge") for one in unions])
        pairs = list(zip(unions, samples, labels, strict=True))
        places = np.array([np.searchsorted(union, s) for union, s, _ in pairs])
        if np.array_equal(times, samples):
            places = np.tile(np.arange(longest), (len(times), 1))
        spins = [np.searchsorted(union, w) for union, _, w in pairs]
        return cls(times, places, np.array(spins).reshape(labels.shape))

    @cached_property
    def _all_samples(self) -> bool:
        """Whether there are no moments but those of the samples, in their order."""
        count = self.samples.shape[1]
        return self.times.shape[1] == count and bool((self.samples == np.arange(count)).all())

    def at_samples(self, rows: Floats) -> Floats:
        """Return (B, N, ...) those of (B, T, ...) rows that belong to samples."""
        if self._all_samples:
            return rows
        places = self.samples.reshape(*self.samples.shape, *(1,) * (rows.ndim - 2))
        found: Floats = np.take_along_axis(rows, places, axis=1)
        return found

    def __getitem__(self, rows: Indices) -> "Moments":
        return Moments(self.times[rows], self.samples[rows], self.labels[rows])

    def repeated(self, count: int) -> "Moments":
        """Return ``count`` copies of each ball's, below one another."""
        return Moments(
            np.repeat(self.times, count, axis=0),
            np.repeat(self.samples, count, axis=0),
            np.repeat(self.labels, count, axis=0),
        )


@dataclass(frozen=True)
class Seen:
    """What a sensor sees of B balls, or what it would see more of them for each of C columns.

    Attributes:
        positions: (B, N, 3) m, or (B, N, 3, C).
        labels: (B, L, 3) rad/s, or (B, L, 3, C).
        velocities: (B, N, 3) of the balls, m/s.
        contacts: (B, M) when balls met something, s from the first sample, NaN where they did not.
        until: (B,) when they first met an edge or the net, and then all is open; NaN if never.
    """

    positions: Floats
    labels: Floats
    velocities: Floats
    contacts: Floats
    until: Floats

    def smooth(self, times: Floats, least: float) -> Bools:
        """Return which of (B, T) times are ``least`` from any contact and not beyond ``until``."""
        near = np.abs(times[..., None] - self.contacts[:, None]) < least
        apart: Bools = np.logical_not(near.any(axis=-1) | (times > self.until[:, None] - least))
        return apart


def _at_samples(shots: Shots) -> bool:
    """Return whether every label is at the time of the sample with its number."""
    count = shots.label_times.shape[1]
    if count > shots.times.shape[1]:
        return False
    at_sample = shots.label_times == shots.times[:, :count]
    return bool((at_sample | ~shots.labelled).all())


def bounces(simulator: Simulator, moments: Moments, unknowns: Floats) -> NDArray[np.int64]:
    """Return (B,) how often each ball bounces off the table before its last moment."""
    flight = simulator.fly(unknowns[:, :STATE_SIZE], moments.times)
    count: NDArray[np.int64] = (flight.contacts.surface == TABLE).sum(axis=1)
    return count


def seen(simulator: Simulator, moments: Moments, unknowns: Floats) -> Seen:
    """Return what a simulator's sensor sees, without noise.

    Args:
        simulator: with its sensor effects; signs of labels are left alone.
        moments: of B balls.
        unknowns: (B, 9 + 3 K) states at the first sample and kicks.
    """
    clock = sensor_quantity(simulator, "clock_gain")
    times = moments.times / clock
    states, contacts, until = path(simulator, unknowns, times)
    spins = np.take_along_axis(states[..., SPIN], moments.labels[..., None], axis=1)
    velocities = moments.at_samples(states[..., VELOCITY])
    speeds = np.sqrt(np.einsum("bni,bni->bn", velocities, velocities))
    delay = np.minimum(sensor_quantity(simulator, "delay", View(speeds)), LATEST)
    if np.any(delay):
        sampled = moments.at_samples(times)
        places = path_in_any_order(simulator, unknowns, sampled - delay)[..., POSITION]
    else:
        places = moments.at_samples(states[..., POSITION])
    positions = sensor_quantity(simulator, "position_gain") * places
    labels = _labels(simulator, spins)
    return Seen(positions, labels, velocities, clock * contacts, clock * until)


def by_unknowns(simulator: Simulator, moments: Moments, unknowns: Floats, view: Seen) -> Seen:
    """Return the derivatives of what is seen by each of a shot's 9 + 3 K unknowns.

    Args:
        simulator: with its sensor effects.
        moments: of B balls.
        unknowns: (B, 9 + 3 K) where.
        view: what is seen there.
    """
    size = unknowns.shape[1]
    steps = np.concatenate([STATE_STEPS, np.full(size - STATE_SIZE, KICK_STEP)])
    shifted = (unknowns[:, None] + np.diag(steps)).reshape(-1, size)
    ahead = seen(simulator, moments.repeated(size), shifted)

    def differences(there: Floats, here: Floats) -> Floats:
        change = there.reshape(len(here), size, *here.shape[1:]) - here[:, None]
        slopes: Floats = np.moveaxis(change, 1, -1) / steps
        return slopes

    contacts = np.swapaxes(ahead.contacts.reshape(len(unknowns), size, -1), 0, 1)
    return Seen(
        differences(ahead.positions, view.positions),
        differences(ahead.labels, view.labels),
        view.velocities,
        view.contacts,
        _until_parted(view, *contacts),
    )


def by_hypotheses(
    simulator: Simulator,
    moments: Moments,
    unknowns: Floats,
    view: Seen,
    columns: tuple[Hypothesis, ...],
) -> Seen:
    """Return the derivatives of what is seen, which is ``view``, by each of the C ``columns``."""
    positions = np.zeros((*view.positions.shape, len(columns)))
    labels = np.zeros((*view.labels.shape, len(columns)))
    contacts = []
    for column, hypothesis in enumerate(columns):
        value, other = hypothesis.value(simulator), hypothesis.nearby(simulator)
        there = seen(hypothesis.at(simulator, other), moments, unknowns)
        positions[..., column] = (there.positions - view.positions) / (other - value)
        labels[..., column] = (there.labels - view.labels) / (other - value)
        contacts.append(there.contacts)
    until = _until_parted(view, *contacts)
    return Seen(positions, labels, view.velocities, view.contacts, until)


def _until_parted(view: Seen, *others: Floats) -> Floats:
    """Return ``view.until``, or the first contact of balls that meet more, or less, in others."""
    until, nothing = view.until, np.full((len(view.until), 1), np.nan)
    for contacts in others:
        more = np.isfinite(contacts).sum(axis=1) != np.isfinite(view.contacts).sum(axis=1)
        first = np.fmin.reduce(np.hstack([view.contacts, contacts, nothing]), axis=1)
        until = np.fmin(until, np.where(more, first, np.nan))
    return until


def _labels(simulator: Simulator, spins: Floats) -> Floats:
    turn = Rotation.from_rotvec(np.array(sensor_quantity(simulator, "spin_label_rotation")))
    turned = turn.apply(spins.reshape(-1, 3)).reshape(spins.shape) if spins.size else spins
    labels: Floats = sensor_quantity(simulator, "spin_label_gain") * turned
    return labels
