"""Measured derivatives beyond the nominal simulator, with the terms of the catalogue's library.

In flight they are the weak form of the equations of motion (Messenger and Bortz 2021), which needs
no derivative of the noise: along an arc

    x(t) = x0 + v0 t + int int [a(s) + F(s) theta],

so the residuals of a fit, in polynomials of degree two and more, are linear in theta. At a bounce
they are the smoothed state after it, less the simulator's from the state before it. Of spin labels
they are the slope along an arc.

The library holds how every parameter of the catalogue changes measurements. At a *measured* state
``s``, a parameter theta changes the next measurement, an acceleration or a state after a bounce, by

    F = d next / d theta - (d next / d s) (d s / d theta).

The second term is that of sensor effects, for which the true state is not the measured one. All
derivatives are finite differences of roll-outs, so new effects need no code.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss, legint, legvander

from experiments.exam.interface import Recording, shots_of
from experiments.exam.methods.regression import Regression, candidates
from experiments.exam.methods.smoothed_arcs import SMOOTH, SmoothedArcs, scaled
from experiments.exam.projection import projected_out
from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import SPIN, STATE_SIZE
from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.gap.fit.measurement import (
    Prediction,
    Schedule,
    hypothesis_derivatives,
    nuisance_derivatives,
    predict_measurements,
)
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.hypotheses import Hypothesis

STENCIL = 2e-3  # s between the times of finite differences of the library
NODES = 6  # of an arc, where the library is evaluated
OFFSET = 5e-3  # s from a bounce to the states before and after it
MINIMUM_LABELS = 5  # of an arc whose spin slope is used
SLOW_SPIN = 30.0  # rad/s; below, the error of a label is that of this spin
# Rough noise: of a coordinate in m, of a label as a share of the spin, of a state near a bounce.
POSITION_NOISE, LABEL_NOISE = 3e-3, 0.05
STATE_NOISE = np.repeat([1e-3, 0.02, LABEL_NOISE], 3)
# Kinds of rows with noise of the same size: tangential, normal and spin components.
AFTER_BOUNCE = np.array([3, 3, 4, 5, 5, 6, 7, 7, 7])
SLIDING = [0, 1, 3, 4, 6, 7, 8]  # components that depend on the spin before the bounce
MINIMUM_NOISE = 0.1  # of the rough one
ROUNDS = 4  # of reweighting
NORMAL_SPREAD = 1.4826  # standard deviation over median absolute deviation of a normal distribution
HUBER = 3.0  # standard deviations; rows with larger residuals have less weight
MINIMUM_SINGULAR_VALUE = 1e-3  # of the largest, in the reweighting fit
RIDGE = 1e-9  # of the trace, where a spin does not act on an arc

# P rows: (P, K + 1) library terms and, last, measured derivatives; the shot and the kind of each.
Rows = tuple[Floats, Integers, Integers]


def derivative_regression(
    recordings: Sequence[Recording], nominal: Simulator, withheld: tuple[str, ...]
) -> Regression:
    """Return the regression of measured derivatives on the catalogue without what is withheld."""
    columns = candidates(nominal, withheld)
    return Regression.of(columns, derivative_grams(shots_of(recordings), nominal, columns))


def derivative_grams(shots: Shots, simulator: Simulator, columns: tuple[Hypothesis, ...]) -> Floats:
    """Return (B, K + 1, K + 1) Gram matrices of shots: K terms and the measured derivatives.

    Rows are in units of the noise, estimated from the residuals of the whole library. The nominal
    simulator has no sensor effects.
    """
    smoothed = SmoothedArcs.of(shots, simulator)
    parts = (*_in_flight(smoothed, columns), _bounces(smoothed, simulator, columns))
    rows, members, kinds = (np.concatenate(part) for part in zip(*parts, strict=True))
    rows = rows * _weights(rows, kinds)[:, None]
    of_shots = (rows[members == shot] for shot in range(len(shots)))
    return np.array([shot_rows.T @ shot_rows for shot_rows in of_shots])


def _selected(rows: Floats, shots: Integers, kinds: Integers, used: Bools) -> Rows:
    """Return the used ones of (R, D, K + 1) rows of (R,) shots and (R, D) kinds."""
    return rows[used], np.repeat(shots[:, None], rows.shape[1], axis=1)[used], kinds[used]


def _in_flight(smoothed: SmoothedArcs, columns: tuple[Hypothesis, ...]) -> tuple[Rows, Rows]:
    """Return the rows of R arcs' positions, and those of their spin labels."""
    nodes, _ = leggauss(NODES)
    times = smoothed.times(nodes)
    acting = [k for k, c in enumerate(columns) if catalogue()[c.effect].acts != "contact"]
    states = smoothed.smooth(times).reshape(-1, STATE_SIZE)
    at_nodes = library(smoothed.simulator, states, 0.0, tuple(columns[k] for k in acting))
    terms = np.zeros((*times.shape, 6, len(columns)))
    terms[..., acting] = at_nodes.terms.reshape(*times.shape, 6, -1)
    expected = at_nodes.expected.reshape(*times.shape, 6)
    by_spin = at_nodes.by_spin.reshape(*times.shape, 6, 3)
    positions = _position_rows(smoothed, terms[:, :, :3], expected[..., :3], by_spin[:, :, :3])
    return positions, _label_rows(
        smoothed, terms[:, :, 3:].mean(axis=1), expected[..., 3:].mean(axis=1)
    )


def _position_rows(
    smoothed: SmoothedArcs, terms: Floats, expected: Floats, by_spin: Floats
) -> Rows:
    """Return the rows of arcs' positions, from terms and accelerations at the nodes."""
    nodes, _ = leggauss(NODES)
    fitted = smoothed.fitted(smoothed.times(nodes))
    of_fit = rates(smoothed.simulator, fitted.reshape(-1, STATE_SIZE))[:, :3]
    beyond = expected - of_fit.reshape(expected.shape)
    # Double integrals of forces at nodes, (R, D, G), in polynomials of degree two and up. These are
    # orthogonal to lines, so constants of integration do not matter.
    twice = legvander(scaled(smoothed.shots, smoothed.shots.times), NODES + 1)
    at_samples = twice @ legint(np.eye(NODES), 2) @ np.linalg.inv(legvander(nodes, NODES - 1))
    high = np.swapaxes(smoothed.columns[:, :, SMOOTH:], 1, 2)
    integral = high @ at_samples * (smoothed.spans / 2)[:, None, None] ** 2
    left = smoothed.residuals[:, SMOOTH:] - _integrated(integral, beyond)
    joined = np.concatenate([_integrated(integral, terms), left[..., None]], axis=-1)
    rows = joined.reshape(len(joined), -1, joined.shape[-1]) / POSITION_NOISE
    unlabelled = ~smoothed.labelled
    spins = _integrated(integral, by_spin).reshape(len(rows), -1, 3)[unlabelled]
    ridge = np.repeat(RIDGE * (spins**2).sum(axis=(1, 2))[:, None], 3, axis=1)
    rows[unlabelled] = projected_out(rows[unlabelled], spins, ridge)
    kinds = np.repeat(unlabelled[:, None], rows.shape[1], axis=1).astype(np.int64)
    return _selected(rows, smoothed.parents, kinds, np.ones(kinds.shape, dtype=bool))


def _label_rows(smoothed: SmoothedArcs, terms: Floats, expected: Floats) -> Rows:
    """Return the rows of labels' slopes over time, in units of a label's error."""
    shots = smoothed.shots
    count = np.maximum(shots.labelled.sum(axis=1), 1)[:, None]
    when, labels = np.nan_to_num(shots.label_times), np.nan_to_num(shots.labels)
    since = np.where(shots.labelled, when - when.sum(axis=1, keepdims=True) / count, 0.0)
    square = np.maximum((since**2).sum(axis=1), 1e-12)[:, None]
    slope = (since[..., None] * labels).sum(axis=1) / square
    size = np.linalg.norm(labels.sum(axis=1) / count, axis=1, keepdims=True)
    joined = np.concatenate([terms, (slope - expected)[..., None]], axis=-1)
    rows = joined * (np.sqrt(square) / LABEL_NOISE / np.maximum(size, SLOW_SPIN))[..., None]
    used = np.repeat(count >= MINIMUM_LABELS, 3, axis=1)
    return _selected(rows, smoothed.parents, np.full(used.shape, 2), used)


def _integrated(integral: Floats, forces: Floats) -> Floats:
    return np.einsum("rdg,rg...->rd...", integral, forces)


def _bounces(smoothed: SmoothedArcs, simulator: Simulator, columns: tuple[Hypothesis, ...]) -> Rows:
    """Return the rows of states after bounces, from those before."""
    first = np.flatnonzero(smoothed.ends[:-1] == smoothed.starts[1:])
    before, after = smoothed.at_bounces(OFFSET)
    before, after = before[first], after[first + 1]
    terms = library(simulator, before, 2 * OFFSET, columns)
    between = (terms.contacts > STENCIL) & (terms.contacts < 2 * OFFSET - STENCIL)
    once = between.any(axis=1) & (np.isfinite(terms.contacts).sum(axis=1) == 1)
    used = np.repeat(once[:, None], STATE_SIZE, axis=1)
    used[:, SPIN] &= smoothed.labelled[first + 1, None]
    used[:, SLIDING] &= smoothed.labelled[first, None]
    noise = np.tile(STATE_NOISE, (len(after), 1))
    noise[:, SPIN] *= np.maximum(np.linalg.norm(after[:, SPIN], axis=1), SLOW_SPIN)[:, None]
    scale = (used / noise)[..., None]
    rows = np.concatenate([terms.terms, (after - terms.expected)[..., None]], axis=-1) * scale
    kinds = AFTER_BOUNCE + len(AFTER_BOUNCE) * ~smoothed.labelled[first, None]
    return _selected(rows, smoothed.parents[first], kinds, used)


def _weights(rows: Floats, kinds: Integers) -> Floats:
    """Return (P,) weights of rows: one over the noise of their kind, and less for outliers.

    The noise is that of the residuals of the whole library (iteratively reweighted least squares).
    """
    norms = np.sqrt((rows**2).sum(axis=0))
    terms, measured = rows[:, :-1] / np.where(norms > 0.0, norms, 1.0)[:-1], rows[:, -1]
    weights, (kinds, member) = np.ones(len(rows)), np.unique(kinds, return_inverse=True)
    for _ in range(ROUNDS):
        slopes = np.linalg.lstsq(
            terms * weights[:, None], measured * weights, rcond=MINIMUM_SINGULAR_VALUE
        )[0]
        residuals = np.abs(measured - terms @ slopes)
        spread = [
            NORMAL_SPREAD * np.median(residuals[member == kind]) for kind in range(len(kinds))
        ]
        noise = np.maximum(spread, MINIMUM_NOISE)[member]
        weights = np.sqrt(np.minimum(1.0, HUBER * noise / np.maximum(residuals, 1e-300))) / noise
    return weights


@dataclass(frozen=True)
class Library:
    """The library at M measured states."""

    terms: Floats  # (M, D, K) derivatives of the next measurement by K parameters
    expected: Floats  # (M, D) next measurement by the simulator
    by_spin: Floats  # (M, D, 3) its derivatives by the measured spin
    contacts: Floats  # (M, C) s from now to contacts, NaN where there are fewer


def library(
    simulator: Simulator, states: Floats, ahead: float, columns: tuple[Hypothesis, ...]
) -> Library:
    """Return the library at (M, 9) states, for later states or for accelerations.

    Args:
        simulator: nominal, without sensor effects.
        states: measured.
        ahead: s to the next measured states (D = 9 components); zero for the rates of change of
            velocity and spin (D = 6).
        columns: the K parameters.
    """
    schedule = _schedule(len(states), ahead)
    prediction = predict_measurements(simulator, schedule, states)
    by_hypotheses = hypothesis_derivatives(simulator, schedule, states, prediction, columns)
    now, later = _measured(by_hypotheses)
    by_now, by_later = _measured(nuisance_derivatives(simulator, schedule, states, prediction))
    slopes = by_later @ np.linalg.inv(by_now)
    contacts = np.where(prediction.smooth_until[:, None] >= 0.0, np.nan, prediction.contacts)
    return Library(later - slopes @ now, _measured(prediction)[1], slopes[:, :, SPIN], contacts)


def rates(simulator: Simulator, states: Floats) -> Floats:
    """Return the (M, 6) rates of change of velocity and spin at (M, 9) states."""
    return _measured(predict_measurements(simulator, _schedule(len(states), 0.0), states))[1]


def _schedule(count: int, ahead: float) -> Schedule:
    """Return the times of finite differences about now, and about ``ahead`` if it is not zero."""
    now = np.array([-STENCIL, 0.0, STENCIL])
    times = np.concatenate([now, ahead + now]) if ahead else now
    return Schedule.of_times(np.tile(times, (count, 1)))


def _measured(prediction: Prediction) -> tuple[Floats, Floats]:
    """Return (M, 9, ...) states now, and those later or (M, 6, ...) rates of velocity and spin."""
    p, w = prediction.positions, prediction.labels
    speeds = (p[:, 2::3] - p[:, 0::3]) / (2 * STENCIL)
    states = np.concatenate([p[:, 1::3], speeds, w[:, 1::3]], axis=2)
    if states.shape[1] > 1:
        return states[:, 0], states[:, 1]
    faster = (p[:, 2] - 2 * p[:, 1] + p[:, 0]) / STENCIL**2
    drift = (w[:, 2] - w[:, 0]) / (2 * STENCIL)
    return states[:, 0], np.concatenate([faster, drift], axis=1)
