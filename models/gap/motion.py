"""Motion: what a simulator's sensor sees of B balls, and how that depends on every unknown.

A shot's unknowns ("nuisance") are its state ``[p v w]`` at its first sample and a *kick* at each of
its first K bounces: what this one bounce did beyond the law. A kick ``(n, s, c)`` is measured in
units of the impact's normal speed: the ball leaves faster by ``n`` upwards, ``s`` along the slip of
its contact point and ``c`` across. The tangential part fades where the slip does, since there
friction has nothing to scatter, and comes with the spin that the conservation of angular momentum
about the contact point asks for, ``dw = -3/(2r) ez x dv``.

Derivatives are differences of exact flights, all unknowns of all shots flown in one call.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from models.ball.contact import NET, TABLE
from models.ball.quantities import View
from models.ball.sensor import sensor_quantity
from models.ball.simulator import Flight, Simulator
from models.ball.state import (
    BALL_RADIUS,
    POSITION,
    SPIN,
    STATE_SIZE,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
    VELOCITY,
)
from models.ball.types import Floats
from models.gap.hypotheses import Hypothesis
from models.gap.shots import Shots

Bools = NDArray[np.bool_]
Indices = NDArray[np.int64]

KICK_SIZE = 3
SLOW_SLIP = 1.0  # m/s below which the tangential part of a kick fades
# So near a bounce, in s, that a sample is not used, since its derivatives have a kink there; and a
# label, since its spin is another one just before and just after.
KINK = 2e-4
JUMP = 5e-3
EDGE = 5e-3  # m from an edge of the table: the ball may have met it
# Steps for differences: m, m/s, rad/s, and kicks in units of the impact's normal speed. Paths are
# so nearly linear in the unknowns that one-sided differences are good to five digits.
STATE_STEPS = np.repeat([1e-5, 1e-4, 0.02], 3)
KICK_STEP = 1e-4


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
        """Return ``count`` copies below one another."""
        return Moments(
            np.tile(self.times, (count, 1)),
            np.tile(self.samples, (count, 1)),
            np.tile(self.labels, (count, 1)),
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
    path, contacts, until = _path(simulator, unknowns, times)
    spins = np.take_along_axis(path[..., SPIN], moments.labels[..., None], axis=1)
    velocities = moments.at_samples(path[..., VELOCITY])
    delay = sensor_quantity(simulator, "delay", View(np.linalg.norm(velocities, axis=-1)))
    if np.any(delay):
        sampled = moments.at_samples(times)
        places = _path_in_any_order(simulator, unknowns, sampled - delay)[..., POSITION]
    else:
        places = moments.at_samples(path[..., POSITION])
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
    shifted = (unknowns + np.diag(steps)[:, None]).reshape(-1, size)
    ahead = seen(simulator, moments.repeated(size), shifted)

    def differences(there: Floats, here: Floats) -> Floats:
        change = there.reshape(size, *here.shape) - here
        slopes: Floats = np.moveaxis(change, 0, -1) / steps
        return slopes

    contacts = ahead.contacts.reshape(size, len(unknowns), -1)
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


def _path(simulator: Simulator, unknowns: Floats, times: Floats) -> tuple[Floats, Floats, Floats]:
    """Return (B, T, 9) states, from bounce to bounce where there are kicks.

    Then (B, M) contact times and (B,) those of the first contact with an edge or the net.
    """
    flight = simulator.fly(unknowns[:, :STATE_SIZE], times)
    path, met = flight.states, [_contacts(flight)]
    rows, start = np.arange(len(path)), np.zeros(len(path))
    for kick in range(STATE_SIZE, unknowns.shape[1], KICK_SIZE):
        there, moment, before, after = first_bounce(flight)
        if not there.any():
            break
        rows, start = rows[there], start[there] + moment
        state = kicked(before, after, unknowns[rows, kick : kick + KICK_SIZE])
        since = times[rows] - start[:, None]
        flight = simulator.fly(state, np.maximum(since, 0.0))
        path[rows] = np.where(since[..., None] > 0.0, flight.states, path[rows])
        met.append(np.full_like(met[0], np.nan))
        met[-1][:, rows] = start[:, None] + _contacts(flight)
    smooth, wild = np.concatenate(met, axis=2)
    return path, smooth[:, np.isfinite(smooth).any(axis=0)], np.fmin.reduce(wild, axis=1)


def _path_in_any_order(simulator: Simulator, unknowns: Floats, times: Floats) -> Floats:
    order = np.argsort(times, axis=1, kind="stable")
    path, _, _ = _path(simulator, unknowns, np.take_along_axis(times, order, axis=1))
    back = np.argsort(order, axis=1, kind="stable")
    return np.take_along_axis(path, back[..., None], axis=1)


def _contacts(flight: Flight) -> Floats:
    """Return (2, B, K) times of contacts, and of those with an edge or the net, else NaN."""
    met = flight.contacts
    x, y = np.abs(met.before[..., 0]), np.abs(met.before[..., 1])
    edge = (x > TABLE_HALF_WIDTH - EDGE) | (y > TABLE_HALF_LENGTH - EDGE)
    wild = edge | (met.surface == NET)
    return np.stack([met.time, np.where(wild, met.time, np.nan)])


def first_bounce(flight: Flight) -> tuple[NDArray[np.bool_], Floats, Floats, Floats]:
    """Return which balls bounce off the table, and when, with which states, those that do."""
    table = flight.contacts.surface == TABLE
    there = table.any(axis=1)
    rows, first = np.flatnonzero(there), table.argmax(axis=1)[there]
    contacts = flight.contacts
    return (
        there,
        contacts.time[rows, first],
        contacts.before[rows, first],
        contacts.after[rows, first],
    )


def kicked(before: Floats, after: Floats, kicks: Floats) -> Floats:
    """Return the (B, 9) states after bounces with (B, 3) kicks."""
    vx, vy, vz, wx, wy, _ = before[:, 3:].T
    slip = np.stack([vx - BALL_RADIUS * wy, vy + BALL_RADIUS * wx], axis=1)
    along = slip / np.sqrt((slip**2).sum(axis=1, keepdims=True) + SLOW_SLIP**2)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    size = np.abs(vz)[:, None]
    sideways = size * (kicks[:, 1:2] * along + kicks[:, 2:3] * across)
    kicked = after.copy()
    kicked[:, 3:5] += sideways
    kicked[:, 5:6] += size * kicks[:, :1]
    kicked[:, 6] += 1.5 / BALL_RADIUS * sideways[:, 1]
    kicked[:, 7] -= 1.5 / BALL_RADIUS * sideways[:, 0]
    return kicked


def _labels(simulator: Simulator, spins: Floats) -> Floats:
    turn = Rotation.from_rotvec(np.array(sensor_quantity(simulator, "spin_label_rotation")))
    turned = turn.apply(spins.reshape(-1, 3)).reshape(spins.shape) if spins.size else spins
    labels: Floats = sensor_quantity(simulator, "spin_label_gain") * turned
    return labels
