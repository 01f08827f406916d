"""Prediction errors before and after amendment, on shots that naming never saw.

A shot is fitted on its first observed samples (and their labels) alone, once about each simulator,
and predicted by the same simulator. Its error at a horizon, counted from the last of these samples,
is the root mean square distance to the measured positions within a window; outliers do not count,
the same for both simulators. A spin without a label has a prior of the size that spins had in
naming, about the same simulator. The error at landing is the distance, in place and in time, of the
first bounce from that of the fitted whole path, kicks included.

The noise floor is the error of a perfect simulator: that of the amended simulator on simulated
replicates of the same shots (a parametric bootstrap; replicates.py), in the noise and scatter found
in naming. Replicates that land where the shot does not, or the other way round, are left out: they
are few and far off, and would lift the floor above the errors.
"""

from dataclasses import dataclass

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import STATE_SIZE
from models.ball.types import Floats
from models.gap.fit.horizons import at_horizons, first_samples
from models.gap.fit.linearize import ballistic_nuisance
from models.gap.fit.measurement import Schedule, predict_measurements
from models.gap.fit.noise import Noise
from models.gap.fit.refit import RefitResult
from models.gap.fit.shot_fit import fit_shots, refit_shots
from models.gap.fit.shots import Shots
from models.gap.settings import GapSettings
from models.gap.types import Bools
from models.gap.verdict import Gap, Landing
from models.gap.verify.bootstrap import interval, resampled, root_mean_squares
from models.gap.verify.landing import Landings, landings
from models.gap.verify.replicates import simulate_replicate


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
    fit: RefitResult,
    before: Simulator,
    after: Simulator,
    noise: Noise,
    spins: tuple[float, float],
    settings: GapSettings,
) -> Errors:
    """Return the errors of two simulators' predictions.

    Args:
        fit: shots that naming never saw, fitted whole, which gives outliers and landings.
        before: the nominal simulator.
        after: amended.
        noise: as naming found it.
        spins: rad/s, sizes of a component of a spin about the one simulator and the other.
        settings: of the workflow.
    """
    own = settings.verify
    long = fit.linear.shots.valid.sum(axis=1) > settings.observed_samples
    shots, states = fit.linear.shots[long], fit.linear.nuisance[long, :STATE_SIZE]
    usable = (fit.linear.shots.valid & (fit.noise_estimate.weights > own.min_inlier))[long]
    true = landings(fit.simulator, states, _durations(shots))
    forecasts = [
        _forecast(shots, true, one, noise, spin, settings)
        for one, spin in zip((before, after), spins, strict=True)
    ]
    forecasts.append(_floor(shots, states, after, noise, spins[1], settings))
    landed = np.stack([[one.places, one.times] for one in forecasts], axis=1)
    landed[:, :, ~np.isfinite(landed).all(axis=(0, 1))] = np.nan
    horizons = np.array(own.horizons)
    return Errors(
        horizons,
        *(at_horizons(shots, one.squares, usable, horizons, settings) for one in forecasts),
        *landed,
    )


def gap(found: Errors, settings: GapSettings, seed: int = 0) -> Gap | None:
    """Return the errors over the horizon and at landing, and how much of the gap closed."""
    reached = np.isfinite(found.before).sum(axis=0) >= settings.verify.min_shots
    if not reached.any():
        return None
    squares = np.stack([found.before, found.after, found.floor])[..., reached]
    sizes, drawn = (
        root_mean_squares(squares),
        resampled(squares, settings.verify.bootstrap_draws, seed),
    )
    before, after, floor = (_thousandths(values) for values in sizes)
    share, level = float(_closed(sizes)), settings.confidence
    return Gap(
        horizons_ms=tuple(round(1000 * h) for h in found.horizons[reached]),
        before_mm=before,
        after_mm=after,
        floor_mm=floor,
        removable_closed=share if np.isfinite(share) else None,
        removable_closed_interval=interval(_closed(drawn), level) if np.isfinite(share) else None,
        landing=_landing(found, settings, seed),
        before_interval_mm=tuple(interval(row, level) for row in 1e3 * drawn[:, 0].T),
        after_interval_mm=tuple(interval(row, level) for row in 1e3 * drawn[:, 1].T),
        reduction_mm=interval(1e3 * _closer(drawn), level),
    )


def _landing(found: Errors, settings: GapSettings, seed: int) -> Landing | None:
    squares = np.stack([found.places, found.times], axis=2)
    squares = squares[:, np.isfinite(squares).all(axis=(0, 2))]
    if squares.shape[1] < settings.verify.min_shots:
        return None
    sizes, drawn = (
        root_mean_squares(squares),
        resampled(squares, settings.verify.bootstrap_draws, seed),
    )
    return Landing(
        shots=squares.shape[1],
        **{
            f"{name}_{unit}": value
            for name, row in zip(("before", "after", "floor"), sizes, strict=True)
            for unit, value in zip(("mm", "ms"), _thousandths(row), strict=True)
        },
        reduction_mm=interval(1e3 * _closer(drawn[..., :1]), settings.confidence),
        reduction_ms=interval(1e3 * _closer(drawn[..., 1:]), settings.confidence),
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
    shots: Shots,
    true: Landings,
    simulator: Simulator,
    noise: Noise,
    spin: float,
    settings: GapSettings,
) -> _Forecast:
    states = _launches(shots, simulator, noise, spin, settings)
    prediction = predict_measurements(simulator, Schedule.of(shots), states)
    squares = ((shots.positions - prediction.positions) ** 2).sum(axis=2)
    forecast = landings(simulator, states, _durations(shots) + settings.verify.landing_horizon)
    place, time = forecast.distances(true)
    missed = np.isfinite(forecast.times) != np.isfinite(true.times)
    return _Forecast(squares, place**2, time**2, missed)


def _floor(
    shots: Shots,
    states: Floats,
    simulator: Simulator,
    noise: Noise,
    spin: float,
    settings: GapSettings,
) -> _Forecast:
    """Return the errors of a perfect simulator: means over replicates of the shots."""
    random = np.random.default_rng(0)
    true = landings(simulator, states, _durations(shots) + settings.verify.landing_horizon)
    kicks = settings.fit.max_kicks
    drawn = [
        simulate_replicate(shots, simulator, states, noise, kicks, random)
        for _ in range(settings.verify.replicates)
    ]
    tries = [_forecast(one, true, simulator, noise, spin, settings) for one in drawn]
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


def _launches(
    shots: Shots, simulator: Simulator, noise: Noise, spin: float, settings: GapSettings
) -> Floats:
    """Return the (B, 9) states that the first samples tell."""
    early = first_samples(shots, settings.observed_samples)
    fit = fit_shots(early, simulator, settings.fit)
    start = ballistic_nuisance(fit.nuisance, 0)
    return refit_shots(early, simulator, start, noise, settings.fit, spin=spin).nuisance


def _durations(shots: Shots) -> Floats:
    """Return (B,) s from the first sample to the last."""
    ends: Floats = shots.times[:, -1] - shots.times[:, 0]
    return ends


def _thousandths(values: Floats) -> tuple[float, ...]:
    return tuple(round(1000 * float(value), 3) for value in values)
