"""Verify: errors of predictions before and after, on shots that naming never saw.

A shot is fitted on its first ``SEEN`` samples (and their labels) alone, once about each simulator,
and flown on by the same simulator. Its error at a horizon, counted from the last of these samples,
is the root mean square distance to the measured positions within ``WINDOW`` of it; outliers do not
count, the same for both simulators. The floor is what a simulator without fault would err: by the
launch that twelve noisy samples tell, by the scatter of bounces and by the sensor, each of the size
found in naming.
"""

from dataclasses import dataclass, replace

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import SPIN, STATE_SIZE
from models.ball.types import Floats
from models.gap.linear import ballistic_unknowns, linearise
from models.gap.motion import Moments, bounces, by_unknowns, seen
from models.gap.noise import Noise, grams, prior_precision
from models.gap.refit import Refitted
from models.gap.shot_fit import MOST_KICKS, fit_shots, refit_shots
from models.gap.shot_fit import SPIN as UNLABELLED_SPIN
from models.gap.shots import Bools, Shots
from models.gap.verdict import Gap

SEEN = 12  # samples
HORIZONS = np.array([0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4])  # s
WINDOW = 0.0125  # s
FEWEST = 3  # shots with samples at a horizon
INLIER = 0.5
DRAWS = 2000


@dataclass(frozen=True)
class Errors:
    """Mean square errors of B shots at H horizons, m^2, NaN where a shot has no samples.

    Attributes:
        horizons: (H,) s.
        before: (B, H) of the simulator as it was.
        after: (B, H) of the amended one.
        floor: (B, H) of one without fault.
    """

    horizons: Floats
    before: Floats
    after: Floats
    floor: Floats


def errors(
    about: Refitted, before: Simulator, after: Simulator, noise: Noise, spin: float
) -> Errors:
    """Return the errors of two simulators' predictions.

    Args:
        about: shots that naming never saw, fitted whole, which tells the outliers.
        before: the simulator as it was.
        after: amended.
        noise: as naming found it.
        spin: typical component of a spin, rad/s, which unlabelled shots err by.
    """
    shots = about.linear.shots
    long = shots.valid.sum(axis=1) > SEEN
    usable = (shots.valid & (about.components.weights > INLIER))[long]
    shots = shots[long]
    squares = [_squares(shots, simulator, noise) for simulator in (before, after)]
    squares.append(_expected(shots, after, noise, spin))
    return Errors(HORIZONS, *(_at_horizons(shots, one, usable) for one in squares))


def gap(found: Errors, seed: int = 0) -> Gap | None:
    """Return the errors over the horizon, and the share of the removable gap that closed."""
    reached = np.isfinite(found.before).sum(axis=0) >= FEWEST
    if not reached.any():
        return None
    parts = np.stack([found.before, found.after, found.floor])[..., reached]
    before, after, floor = _root_mean_square(parts)
    shots = parts.shape[1]
    drawn = np.random.default_rng(seed).integers(shots, size=(DRAWS, shots))
    closed = [_closed(_root_mean_square(parts[:, rows])) for rows in drawn]
    share = _closed(np.stack([before, after, floor]))
    low, high = np.nanquantile(closed, [0.025, 0.975]) if np.isfinite(closed).any() else (0, 0)
    return Gap(
        horizons_ms=tuple(round(1000 * h) for h in found.horizons[reached]),
        before_mm=_millimetres(before),
        after_mm=_millimetres(after),
        floor_mm=_millimetres(floor),
        removable_closed=float(share) if np.isfinite(share) else None,
        interval=(float(low), float(high)) if np.isfinite(share) else None,
    )


def first_samples(shots: Shots, count: int) -> Shots:
    """Return the first samples of shots, and the labels up to the last of them."""
    last = shots.times[:, count - 1 : count]
    known = np.asarray(shots.label_times <= last)
    width = int(known.sum(axis=1).max(initial=0))
    labels = np.where(known[..., None], shots.labels, np.nan)[:, :width]
    return replace(
        shots,
        times=shots.times[:, :count],
        positions=shots.positions[:, :count],
        valid=shots.valid[:, :count],
        label_times=np.where(known, shots.label_times, np.nan)[:, :width],
        labels=labels,
    )


def _launches(shots: Shots, simulator: Simulator, noise: Noise) -> tuple[Shots, Floats]:
    """Return the first samples, and the (B, 9) states that they tell."""
    early = first_samples(shots, SEEN)
    fit = fit_shots(early, simulator)
    known = refit_shots(early, simulator, ballistic_unknowns(fit.unknowns, 0), noise)
    return early, known.unknowns


def _squares(shots: Shots, simulator: Simulator, noise: Noise) -> Floats:
    _, states = _launches(shots, simulator, noise)
    view = seen(simulator, Moments.of(shots), states)
    squares: Floats = ((shots.positions - view.positions) ** 2).sum(axis=2)
    return squares


def _expected(shots: Shots, simulator: Simulator, noise: Noise, spin: float) -> Floats:
    """Return (B, N) expected squares of the errors of a simulator without fault."""
    early, states = _launches(shots, simulator, noise)
    moments = Moments.of(shots)
    kicks = min(int(bounces(simulator, moments, states).max(initial=0)), MOST_KICKS)
    unknowns = ballistic_unknowns(states, kicks)
    slopes = by_unknowns(simulator, moments, unknowns, seen(simulator, moments, unknowns)).positions
    covariance = np.zeros((len(shots), unknowns.shape[1], unknowns.shape[1]))
    covariance[:, :STATE_SIZE, :STATE_SIZE] = _launch_errors(early, simulator, states, noise, spin)
    scatter = np.arange(STATE_SIZE, unknowns.shape[1])
    covariance[:, scatter, scatter] = np.tile(np.array(noise.scatter) ** 2, kicks)
    launch: Floats = np.einsum("bnie,bef,bnif->bn", slopes, covariance, slopes, optimize=True)
    return launch + 3 * noise.position**2


def _launch_errors(
    early: Shots, simulator: Simulator, states: Floats, noise: Noise, spin: float
) -> Floats:
    """Return (B, 9, 9) covariances of launches fitted with a prior on spins without a label."""
    linear = linearise(early, simulator, states, ())
    parts = grams(linear, noise, linear.sampled.astype(float), np.ones(len(early)))
    own = np.arange(STATE_SIZE)
    measured = parts.total(noise)[:, own][:, :, own]
    measured[:, own, own] -= parts.precision(noise)
    unlabelled = parts.counts == 0
    pull = prior_precision(unlabelled, STATE_SIZE, noise, UNLABELLED_SPIN)
    inverse = np.linalg.inv(measured + pull[:, None] * np.eye(STATE_SIZE))
    true = np.zeros_like(pull)
    true[unlabelled, SPIN] = spin**2
    middle = measured + (pull**2 * true)[:, None] * np.eye(STATE_SIZE)
    covariance: Floats = inverse @ middle @ inverse
    return covariance


def _at_horizons(shots: Shots, squares: Floats, usable: Bools) -> Floats:
    """Return (B, H) means of (B, N) squares about the horizons."""
    since = shots.times - shots.times[:, SEEN - 1 : SEEN]
    near = usable[:, None] & (np.abs(since[:, None] - HORIZONS[:, None]) <= WINDOW)
    count = near.sum(axis=2)
    total = (near * squares[:, None]).sum(axis=2)
    means: Floats = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return means


def _root_mean_square(squares: Floats) -> Floats:
    there = np.isfinite(squares)
    count = np.maximum(there.sum(axis=1), 1)
    roots: Floats = np.sqrt(np.where(there, squares, 0.0).sum(axis=1) / count)
    return roots


def _closed(parts: Floats) -> float:
    """Return the ratio of sums over horizons of (3, H) errors before, after and at the floor."""
    before, after, floor = parts.sum(axis=1)
    return float((before - after) / (before - floor)) if before > floor else np.nan


def _millimetres(values: Floats) -> tuple[float, ...]:
    return tuple(round(1000 * float(value), 3) for value in values)
