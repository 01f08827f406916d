"""Derivatives: what moves smoothed balls beyond the nominal simulator, on the catalogue's library.

In flight the weak form of the equations of motion is taken (Messenger and Bortz 2021), which needs
no derivative of the noise: along an arc

    x(t) = x0 + v0 t + int int [a(s) + F(s) theta],

so that what a fit leaves of the arc, in polynomials of degree two and more, is linear in theta. At
a bounce it is the smoothed state after it, less what the simulator makes of that before it; and of
spin labels their drift along an arc.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss, legint, legvander

from models.ball.catalogue import catalogue
from models.ball.simulator import Simulator
from models.ball.state import SPIN, STATE_SIZE
from models.ball.types import Floats
from models.exam.methods.library import STENCIL, library, rates
from models.exam.methods.smoothed_arcs import SMOOTH, Smoothed, cut
from models.gap.fit.shots import Shots
from models.gap.hypotheses import Hypothesis
from models.gap.types import Bools, Indices

NODES = 6  # of an arc, where the library is evaluated
BESIDE = 5e-3  # s from a bounce to the states before and after it
FEWEST_LABELS = 5  # of an arc whose spin may drift
SLOW_SPIN = 30.0  # rad/s below which errors of labels shrink no more
# Rough noise: of a coordinate in m, of a label as a share of the spin, of a state beside a bounce.
PLACE, LABEL = 3e-3, 0.05
BESIDE_BOUNCE = np.repeat([1e-3, 0.02, LABEL], 3)
# Kinds of rows whose noise is of the same size: along the surface, across it, and spins.
AFTER_BOUNCE = np.array([3, 3, 4, 5, 5, 6, 7, 7, 7])
SLIDING = [0, 1, 3, 4, 6, 7, 8]  # the components that depend on the spin before the bounce
LEAST_NOISE = 0.1  # of the rough one
ROUNDS = 4
NORMAL_SPREAD = 1.4826  # standard deviation over median deviation of a normal
MOST = 3.0  # standard deviations from which on a row counts less
ALIKE = 1e-3  # singular values, of the largest, of terms that are too much alike


def derivatives(shots: Shots, simulator: Simulator, columns: tuple[Hypothesis, ...]) -> Floats:
    """Return (B, K + 1, K + 1) Gram matrices of shots: K terms and what the simulator lacks.

    They are those of rows in units of the noise, as large as what the whole library leaves.

    Args:
        shots: measured.
        simulator: nominal, without sensor effects.
        columns: the library.
    """
    smoothed = Smoothed.of(cut(shots, simulator), simulator)
    parts = (*_in_flight(smoothed, columns), _bounces(smoothed, simulator, columns))
    rows = np.concatenate([part.rows for part in parts])
    of = np.concatenate([part.shots for part in parts])
    kinds = np.concatenate([part.kinds for part in parts])
    rows = rows * _weights(rows, kinds)[:, None]
    grams = [rows[of == shot].T @ rows[of == shot] for shot in range(len(shots))]
    return np.array(grams)


@dataclass(frozen=True)
class _Part:
    """P rows of the regression.

    Attributes:
        rows: (P, K + 1) library terms, and last what is measured.
        shots: (P,) which shot each is from.
        kinds: (P,) which rows have noise of the same size.
    """

    rows: Floats
    shots: Indices
    kinds: Indices

    @classmethod
    def of(cls, rows: Floats, shots: Indices, kinds: Indices, used: Bools) -> "_Part":
        """Return the used ones of (R, D, K + 1) rows of (R,) shots and (R, D) kinds."""
        each = np.repeat(shots[:, None], rows.shape[1], axis=1)
        return cls(rows[used], each[used], kinds[used])


def _in_flight(smoothed: Smoothed, columns: tuple[Hypothesis, ...]) -> tuple[_Part, _Part]:
    """Return the rows of R arcs' paths, and those of their spin labels."""
    nodes, _ = leggauss(NODES)
    times = smoothed.times(nodes)
    acting = [k for k, one in enumerate(columns) if catalogue()[one.effect].acts != "contact"]
    states = smoothed.smooth(times).reshape(-1, STATE_SIZE)
    found = library(smoothed.simulator, states, 0.0, tuple(columns[k] for k in acting))
    terms = np.zeros((*times.shape, 6, len(columns)))
    terms[..., acting] = found.terms.reshape(*times.shape, 6, -1)
    expected = found.expected.reshape(*times.shape, 6)
    by_spin = found.by_spin.reshape(*times.shape, 6, 3)
    path = _path(smoothed, terms[:, :, :3], expected[..., :3], by_spin[:, :, :3])
    return path, _drift(smoothed, terms[:, :, 3:].mean(axis=1), expected[..., 3:].mean(axis=1))


def _path(smoothed: Smoothed, terms: Floats, expected: Floats, by_spin: Floats) -> _Part:
    """Return the rows of arcs' paths, from terms, accelerations and their slopes at the nodes."""
    fitted = smoothed.fitted(smoothed.times(leggauss(NODES)[0]))
    told = rates(smoothed.simulator, fitted.reshape(-1, STATE_SIZE))[:, :3]
    beyond = expected - told.reshape(expected.shape)
    integral = _integrals(smoothed)
    left = smoothed.left[:, SMOOTH:] - _along(integral, beyond)
    joined = np.concatenate([_along(integral, terms), left[..., None]], axis=-1)
    rows = joined.reshape(len(joined), -1, joined.shape[-1]) / PLACE
    unlabelled = ~smoothed.arcs.labelled
    spins = _along(integral, by_spin).reshape(len(rows), -1, 3)
    rows[unlabelled] = _without(rows[unlabelled], spins[unlabelled])
    kinds = np.repeat(unlabelled[:, None], rows.shape[1], axis=1).astype(np.int64)
    return _Part.of(rows, smoothed.arcs.parents, kinds, np.ones(kinds.shape, dtype=bool))


def _drift(smoothed: Smoothed, terms: Floats, expected: Floats) -> _Part:
    """Return the rows of labels' slopes over time, in units of a label's relative error."""
    shots = smoothed.arcs.shots
    count = np.maximum(shots.labelled.sum(axis=1), 1)[:, None]
    when, labels = np.nan_to_num(shots.label_times), np.nan_to_num(shots.labels)
    since = np.where(shots.labelled, when - when.sum(axis=1, keepdims=True) / count, 0.0)
    square = np.maximum((since**2).sum(axis=1), 1e-12)[:, None]
    slope = (since[..., None] * labels).sum(axis=1) / square
    size = np.linalg.norm(labels.sum(axis=1) / count, axis=1, keepdims=True)
    joined = np.concatenate([terms, (slope - expected)[..., None]], axis=-1)
    rows = joined * (np.sqrt(square) / LABEL / np.maximum(size, SLOW_SPIN))[..., None]
    used = np.repeat(count >= FEWEST_LABELS, 3, axis=1)
    return _Part.of(rows, smoothed.arcs.parents, np.full(used.shape, 2), used)


def _integrals(smoothed: Smoothed) -> Floats:
    """Return (R, D, G) that integrate forces at nodes twice, in polynomials of degree two and up.

    These are orthogonal to lines, so constants of integration do not matter.
    """
    nodes, _ = leggauss(NODES)
    scaled = smoothed.scaled(smoothed.arcs.shots.times)
    twice = legvander(scaled, NODES + 1) @ legint(np.eye(NODES), 2)
    at_samples = twice @ np.linalg.inv(legvander(nodes, NODES - 1))
    high = np.swapaxes(smoothed.columns[:, :, SMOOTH:], 1, 2)
    integrals: Floats = high @ at_samples * (smoothed.spans / 2)[:, None, None] ** 2
    return integrals


def _along(integral: Floats, forces: Floats) -> Floats:
    along: Floats = np.einsum("rdg,rg...->rd...", integral, forces)
    return along


def _without(rows: Floats, nuisance: Floats) -> Floats:
    """Return (R, D, C) rows without what (R, D, 3) unknown spins may do to them."""
    cross = np.swapaxes(nuisance, 1, 2)
    inner = cross @ nuisance
    inner += 1e-9 * np.trace(inner, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    left: Floats = rows - nuisance @ np.linalg.solve(inner, cross @ rows)
    return left


def _bounces(smoothed: Smoothed, simulator: Simulator, columns: tuple[Hypothesis, ...]) -> _Part:
    """Return the rows of states after bounces, given those before."""
    arcs = smoothed.arcs
    first = np.flatnonzero(arcs.ends[:-1] == arcs.starts[1:])
    before, after = smoothed.beside_bounces(BESIDE)
    before, after = before[first], after[first + 1]
    found = library(simulator, before, 2 * BESIDE, columns)
    used = np.repeat(_once(found.contacts)[:, None], STATE_SIZE, axis=1)
    used[:, SPIN] &= arcs.labelled[first + 1, None]
    used[:, SLIDING] &= arcs.labelled[first, None]
    scale = (used / _rough_noise(after))[..., None]
    rows = np.concatenate([found.terms, (after - found.expected)[..., None]], axis=-1) * scale
    kinds = AFTER_BOUNCE + len(AFTER_BOUNCE) * ~arcs.labelled[first, None]
    return _Part.of(rows, arcs.parents[first], kinds, used)


def _rough_noise(states: Floats) -> Floats:
    noise = np.tile(BESIDE_BOUNCE, (len(states), 1))
    noise[:, SPIN] *= np.maximum(np.linalg.norm(states[:, SPIN], axis=1), SLOW_SPIN)[:, None]
    return noise


def _once(contacts: Floats) -> Bools:
    """Return which balls meet something once, well between the state before and that after."""
    between = (contacts > STENCIL) & (contacts < 2 * BESIDE - STENCIL)
    once: Bools = between.any(axis=1) & (np.isfinite(contacts).sum(axis=1) == 1)
    return once


def _weights(rows: Floats, kinds: Indices) -> Floats:
    """Return (P,) weights of rows: one over the noise of their kind, and less for those far off.

    The noise is what the whole library leaves.
    """
    norms = np.sqrt((rows**2).sum(axis=0))
    terms, measured = rows[:, :-1] / np.where(norms > 0.0, norms, 1.0)[:-1], rows[:, -1]
    weights, (kinds, member) = np.ones(len(rows)), np.unique(kinds, return_inverse=True)
    for _ in range(ROUNDS):
        slopes = np.linalg.lstsq(terms * weights[:, None], measured * weights, rcond=ALIKE)[0]
        miss = np.abs(measured - terms @ slopes)
        spread = [NORMAL_SPREAD * np.median(miss[member == kind]) for kind in range(len(kinds))]
        noise = np.maximum(spread, LEAST_NOISE)[member]
        weights = np.sqrt(np.minimum(1.0, MOST * noise / np.maximum(miss, 1e-300))) / noise
    return weights
