"""Verify: errors of predictions before and after, on shots that naming never saw.

A shot is fitted on its first ``SEEN`` samples (and their labels) alone, once about each simulator,
and flown on by the same simulator. Its error at a horizon, counted from the last of these samples,
is the root mean square distance to the measured positions within ``WINDOW`` of it; outliers do not
count, the same for both simulators. A spin without a label is expected to be of the size that spins
had in naming, about the same simulator: what a few samples tell of it is little. Its error at
landing is how far its first bounce is, in place and in time, from that of the whole path as fitted,
kicks and all. The floor is what a simulator without fault would err: by the launch that twelve
noisy samples tell, by the scatter of bounces and by the sensor, each of the size found in naming.
"""

from dataclasses import dataclass, replace

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import STATE_SIZE
from models.ball.types import Floats
from models.gap.landing import landings, spread
from models.gap.linear import ballistic_unknowns, linearise
from models.gap.motion import Moments, bounces, by_unknowns, seen
from models.gap.noise import Noise, grams, prior_precision
from models.gap.refit import Refitted
from models.gap.resampled import interval, resampled, root_mean_squares
from models.gap.shot_fit import MOST_KICKS, fit_shots, refit_shots
from models.gap.shots import Shots
from models.gap.types import Bools
from models.gap.verdict import Gap, Landing

SEEN = 12  # samples
HORIZONS = np.array([0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4])  # s
WINDOW = 0.0125  # s
FEWEST = 3  # shots with samples at a horizon, or that land
INLIER = 0.5
LATE = 0.2  # s after a shot's last sample, until when predictions may land


@dataclass(frozen=True)
class Errors:
    """Mean square errors of B shots at H horizons and at landing, NaN where a shot has none.

    Attributes:
        horizons: (H,) s.
        before: (B, H) m^2 of the simulator as it was.
        after: (B, H) of the amended one.
        floor: (B, H) of one without fault.
        places: (3, B) m^2 at landing, in the same order.
        times: (3, B) s^2.
    """

    horizons: Floats
    before: Floats
    after: Floats
    floor: Floats
    places: Floats
    times: Floats


def errors(
    about: Refitted,
    before: Simulator,
    after: Simulator,
    noise: Noise,
    spins: tuple[float, float],
) -> Errors:
    """Return the errors of two simulators' predictions.

    Args:
        about: shots that naming never saw, fitted whole, which tells outliers and landings.
        before: the simulator as it was.
        after: amended.
        noise: as naming found it.
        spins: rad/s, sizes of a component of a spin about the one simulator and the other.
    """
    long = about.linear.shots.valid.sum(axis=1) > SEEN
    shots, unknowns = about.linear.shots[long], about.linear.unknowns[long]
    usable = (about.linear.shots.valid & (about.components.weights > INLIER))[long]
    simulators = before, after
    launches = [
        _launches(shots, one, noise, spin) for one, spin in zip(simulators, spins, strict=True)
    ]
    told = _launch_errors(first_samples(shots, SEEN), after, launches[1], noise, spins[1])
    squares = [
        *(_squares(shots, one, states) for one, states in zip(simulators, launches, strict=True)),
        _expected(shots, after, launches[1], noise, told),
    ]
    ends = shots.times[:, -1] - shots.times[:, 0]
    true = landings(about.simulator, unknowns[:, :STATE_SIZE], ends)
    apart = [
        landings(one, states, ends + LATE).apart(true)
        for one, states in zip(simulators, launches, strict=True)
    ]
    landed = np.stack([*np.square(apart), spread(after, launches[1], ends + LATE, told)], axis=1)
    landed[:, :, ~np.isfinite(landed).all(axis=(0, 1))] = np.nan
    return Errors(
        HORIZONS, *(at_horizons(shots, one, usable, HORIZONS) for one in squares), *landed
    )


def gap(found: Errors, seed: int = 0) -> Gap | None:
    """Return the errors over the horizon and at landing, and how much of the gap closed."""
    reached = np.isfinite(found.before).sum(axis=0) >= FEWEST
    if not reached.any():
        return None
    squares = np.stack([found.before, found.after, found.floor])[..., reached]
    sizes, drawn = root_mean_squares(squares), resampled(squares, seed)
    before, after, floor = (_thousandths(values) for values in sizes)
    share = float(_closed(sizes))
    return Gap(
        horizons_ms=tuple(round(1000 * h) for h in found.horizons[reached]),
        before_mm=before,
        after_mm=after,
        floor_mm=floor,
        removable_closed=share if np.isfinite(share) else None,
        interval=interval(_closed(drawn)) if np.isfinite(share) else None,
        landing=_landing(found, seed),
        before_interval_mm=tuple(interval(row) for row in 1e3 * drawn[:, 0].T),
        after_interval_mm=tuple(interval(row) for row in 1e3 * drawn[:, 1].T),
        closer_mm=interval(1e3 * _closer(drawn)),
    )


def _landing(found: Errors, seed: int) -> Landing | None:
    squares = np.stack([found.places, found.times], axis=2)
    squares = squares[:, np.isfinite(squares).all(axis=(0, 2))]
    if squares.shape[1] < FEWEST:
        return None
    sizes, drawn = root_mean_squares(squares), resampled(squares, seed)
    return Landing(
        shots=squares.shape[1],
        **{
            f"{name}_{unit}": value
            for name, row in zip(("before", "after", "floor"), sizes, strict=True)
            for unit, value in zip(("mm", "ms"), _thousandths(row), strict=True)
        },
        closer_mm=interval(1e3 * _closer(drawn[..., :1])),
        closer_ms=interval(1e3 * _closer(drawn[..., 1:])),
    )


def _closer(sizes: Floats) -> Floats:
    """Return by how much errors (..., 3, H) before, after and at the floor fell, their mean."""
    closer: Floats = (sizes[..., 0, :] - sizes[..., 1, :]).mean(axis=-1)
    return closer


def _closed(sizes: Floats) -> Floats:
    """Return the ratio of sums over horizons of (..., 3, H) errors before, after and at the floor.

    It is NaN where there is nothing to close.
    """
    before, after, floor = np.moveaxis(sizes.sum(axis=-1), -1, 0)
    removable = np.where(before > floor, before - floor, np.nan)
    closed: Floats = (before - after) / removable
    return closed


def last_seen(shots: Shots) -> Floats:
    """Return (B, 1) times of the last samples that predictions see, s."""
    place = min(SEEN, shots.times.shape[1]) - 1
    return shots.times[:, place : place + 1]


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


def at_horizons(shots: Shots, values: Floats, usable: Bools, horizons: Floats) -> Floats:
    """Return (B, H, ...) means of (B, N, ...) values about horizons, NaN where there are none.

    Args:
        shots: B of them.
        values: at their samples.
        usable: (B, N) samples that count.
        horizons: (H,) s from the last sample that a prediction sees.
    """
    since = shots.times - last_seen(shots)
    near = usable[:, None] & (np.abs(since[:, None] - horizons[:, None]) <= WINDOW)
    count = near.sum(axis=2)
    shares = near / np.where(count > 0, count, np.nan)[..., None]
    means: Floats = np.einsum("bhn,bn...->bh...", shares, values, optimize=True)
    return means


def _launches(shots: Shots, simulator: Simulator, noise: Noise, spin: float) -> Floats:
    """Return the (B, 9) states that the first samples tell."""
    early = first_samples(shots, SEEN)
    fit = fit_shots(early, simulator)
    begin = ballistic_unknowns(fit.unknowns, 0)
    return refit_shots(early, simulator, begin, noise, spin=spin).unknowns


def _squares(shots: Shots, simulator: Simulator, states: Floats) -> Floats:
    view = seen(simulator, Moments.of(shots), states)
    squares: Floats = ((shots.positions - view.positions) ** 2).sum(axis=2)
    return squares


def _expected(
    shots: Shots, simulator: Simulator, states: Floats, noise: Noise, told: Floats
) -> Floats:
    """Return (B, N) expected squares of the errors of a simulator without fault.

    Args:
        shots: B of them.
        simulator: without fault.
        states: (B, 9) of their launches.
        noise: of positions, and scatter.
        told: (B, 9, 9) covariance of the launches.
    """
    moments = Moments.of(shots)
    kicks = min(int(bounces(simulator, moments, states).max(initial=0)), MOST_KICKS)
    unknowns = ballistic_unknowns(states, kicks)
    view = seen(simulator, moments, unknowns)
    slopes = by_unknowns(simulator, moments, unknowns, view).positions
    covariance = np.zeros((len(shots), unknowns.shape[1], unknowns.shape[1]))
    covariance[:, :STATE_SIZE, :STATE_SIZE] = told
    scatter = np.arange(STATE_SIZE, unknowns.shape[1])
    covariance[:, scatter, scatter] = np.tile(np.array(noise.scatter) ** 2, kicks)
    launch: Floats = np.einsum("bnie,bef,bnif->bn", slopes, covariance, slopes, optimize=True)
    stamps: Floats = noise.timing**2 * (view.velocities**2).sum(axis=2)
    return launch + 3 * noise.position**2 + stamps


def _launch_errors(
    early: Shots, simulator: Simulator, states: Floats, noise: Noise, spin: float
) -> Floats:
    """Return (B, 9, 9) covariances of launches, where spins without a label have a prior."""
    linear = linearise(early, simulator, states, ())
    parts = grams(linear, noise, linear.sampled.astype(float), np.ones(len(early)))
    own = np.arange(STATE_SIZE)
    measured = parts.total(noise)[:, own][:, :, own]
    measured[:, own, own] -= parts.precision(noise)
    prior = prior_precision(parts.counts == 0, STATE_SIZE, noise, spin)
    inverse = np.linalg.inv(measured + prior[:, None] * np.eye(STATE_SIZE))
    return np.asarray(inverse, dtype=np.float64)


def _thousandths(values: Floats) -> tuple[float, ...]:
    return tuple(round(1000 * float(value), 3) for value in values)
