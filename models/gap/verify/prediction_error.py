"""Verify: errors of predictions before and after, on shots that naming never saw.

A shot is fitted on its first ``SEEN`` samples (and their labels) alone, once about each simulator,
and flown on by the same simulator. Its error at a horizon, counted from the last of these samples,
is the root mean square distance to the measured positions within ``WINDOW`` of it; outliers do not
count, the same for both simulators. A spin without a label is expected to be of the size that spins
had in naming, about the same simulator: what a few samples tell of it is little. Its error at
landing is how far its first bounce is, in place and in time, from that of the whole path as fitted,
kicks and all. The floor is what a simulator without fault would err: the amended one's errors on
rehearsals of the same shots, flown by itself with bounces and a sensor that err by the sizes found
in naming (rehearsal.py). Rehearsals that it takes to miss the table, or to hit it, where they do
not, are left out: they are few and far off, and by luck would lift the floor above the errors.
"""

from dataclasses import dataclass

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import STATE_SIZE
from models.ball.types import Floats
from models.gap.fit.horizons import SEEN, at_horizons, first_samples
from models.gap.fit.linearize import ballistic_unknowns
from models.gap.fit.measurement import Moments, seen
from models.gap.fit.noise import Noise
from models.gap.fit.refit import Refitted
from models.gap.fit.shot_fit import fit_shots, refit_shots
from models.gap.fit.shots import Shots
from models.gap.types import Bools
from models.gap.verdict import Gap, Landing
from models.gap.verify.bootstrap import interval, resampled, root_mean_squares
from models.gap.verify.landing import Landings, landings
from models.gap.verify.replicates import rehearsed

HORIZONS = np.array([0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4])  # s
FEWEST = 3  # shots with samples at a horizon, or that land
INLIER = 0.5
LATE = 0.2  # s after a shot's last sample, until when predictions may land
REHEARSALS = 3


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
    shots, states = about.linear.shots[long], about.linear.unknowns[long, :STATE_SIZE]
    usable = (about.linear.shots.valid & (about.components.weights > INLIER))[long]
    true = landings(about.simulator, states, _ends(shots))
    forecasts = [
        _forecast(shots, true, one, noise, spin)
        for one, spin in zip((before, after), spins, strict=True)
    ]
    forecasts.append(_floor(shots, states, after, noise, spins[1]))
    landed = np.stack([[one.places, one.times] for one in forecasts], axis=1)
    landed[:, :, ~np.isfinite(landed).all(axis=(0, 1))] = np.nan
    return Errors(
        HORIZONS, *(at_horizons(shots, one.squares, usable, HORIZONS) for one in forecasts), *landed
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


@dataclass(frozen=True)
class _Forecast:
    """Squares of the errors of forecasts of B balls, NaN where there are none.

    Attributes:
        squares: (B, N) m^2 at the samples.
        places: (B,) m^2 at landing.
        times: (B,) s^2 at landing.
        missed: (B,) balls that are forecast to land and do not, or the other way round.
    """

    squares: Floats
    places: Floats
    times: Floats
    missed: Bools


def _forecast(
    shots: Shots, true: Landings, simulator: Simulator, noise: Noise, spin: float
) -> _Forecast:
    states = _launches(shots, simulator, noise, spin)
    view = seen(simulator, Moments.of(shots), states)
    squares = ((shots.positions - view.positions) ** 2).sum(axis=2)
    forecast = landings(simulator, states, _ends(shots) + LATE)
    place, time = forecast.apart(true)
    missed = np.isfinite(forecast.times) != np.isfinite(true.times)
    return _Forecast(squares, place**2, time**2, missed)


def _floor(
    shots: Shots, states: Floats, simulator: Simulator, noise: Noise, spin: float
) -> _Forecast:
    """Return what a simulator without fault would err: means over rehearsals of the shots."""
    random = np.random.default_rng(0)
    true = landings(simulator, states, _ends(shots) + LATE)
    drawn = [rehearsed(shots, simulator, states, noise, random) for _ in range(REHEARSALS)]
    tries = [_forecast(one, true, simulator, noise, spin) for one in drawn]
    missed = np.stack([one.missed for one in tries])
    return _Forecast(
        _means_of_others(np.stack([one.squares for one in tries]), missed),
        _means_of_others(np.stack([one.places for one in tries]), missed),
        _means_of_others(np.stack([one.times for one in tries]), missed),
        np.asarray(missed.all(axis=0), dtype=np.bool_),
    )


def _means_of_others(values: Floats, left_out: Bools) -> Floats:
    """Return (B, ...) means of (R, B, ...) values that are not left out, NaN where all are."""
    kept = ~left_out.reshape(*left_out.shape, *(1,) * (values.ndim - 2))
    count = kept.sum(axis=0)
    means: Floats = np.where(kept, values, 0.0).sum(axis=0) / np.where(count > 0, count, np.nan)
    return means


def _launches(shots: Shots, simulator: Simulator, noise: Noise, spin: float) -> Floats:
    """Return the (B, 9) states that the first samples tell."""
    early = first_samples(shots, SEEN)
    fit = fit_shots(early, simulator)
    begin = ballistic_unknowns(fit.unknowns, 0)
    return refit_shots(early, simulator, begin, noise, spin=spin).unknowns


def _ends(shots: Shots) -> Floats:
    """Return (B,) s from the first sample to the last."""
    ends: Floats = shots.times[:, -1] - shots.times[:, 0]
    return ends


def _thousandths(values: Floats) -> tuple[float, ...]:
    return tuple(round(1000 * float(value), 3) for value in values)
