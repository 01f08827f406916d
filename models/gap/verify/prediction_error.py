"""Prediction errors before and after amendment, on held-out shots.

A shot is fitted on its first observed samples (and their labels) alone, once about each simulator,
and predicted by the same simulator. Its error at a horizon, counted from the last of these samples,
is the root mean square distance to the measured positions within a window; outliers do not count,
the same for both simulators. The error at landing is the distance, in place and in time, of the
first bounce from that of the fitted whole path, kicks included.

The floor is the error of a correct simulator: that of the amended simulator on simulated replicates
of the same shots (a parametric bootstrap; replicates.py). Replicates that land where the shot does
not, or the other way round, are left out: they are few and would lift the floor above the errors.
"""

from dataclasses import dataclass, replace

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.horizons import at_horizons, first_samples
from rallygap.models.gap.fit.linearize import ballistic_nuisance
from rallygap.models.gap.fit.measurement import Schedule, predict_measurements
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.fit.shot_fit import fit_shots, refit_shots
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.types import Bools
from rallygap.models.gap.verdict import Gap, Landing
from rallygap.models.gap.verify.bootstrap import interval, resampled, root_mean_squares
from rallygap.models.gap.verify.landing import Landings, landings
from rallygap.models.gap.verify.replicates import simulate_replicate


@dataclass(frozen=True)
class Errors:
    """Mean square errors of B shots before and after amendment, and of the floor.

    Attributes:
        horizons: (H,) s.
        squares: (3, B, H) m^2, NaN where a shot has none.
        landings: (3, B, 2) m^2 and s^2 at landing, NaN where a shot has none.
    """

    horizons: Floats
    squares: Floats
    landings: Floats


@dataclass(frozen=True)
class HeldOut:
    """Held-out shots that are long enough for predictions.

    Attributes:
        shots: as they were measured, with corrected signs of labels.
        corrected: less the position-dependent camera error; the same where they have none.
        usable: (B, N) samples that are no outliers.
        states: (B, 9) that fit the whole shots.
        simulator: about which they were fitted.
        noise: as estimated in naming.
        settings: of the workflow.
    """

    shots: Shots
    corrected: Shots
    usable: Bools
    states: Floats
    simulator: Simulator
    noise: Noise
    settings: GapSettings

    @classmethod
    def of(
        cls, fit: RefitResult, measured: Shots, noise: Noise, settings: GapSettings
    ) -> "HeldOut":
        """Return the shots that are long enough, corrected by ``fit`` and as ``measured``."""
        long = fit.linear.shots.valid.sum(axis=1) > settings.observed_samples
        inlier = fit.noise_estimate.weights > settings.verify.min_inlier
        return cls(
            replace(fit.linear.shots, positions=measured.positions)[long],
            fit.linear.shots[long],
            (fit.linear.shots.valid & inlier)[long],
            fit.linear.nuisance[long, :STATE_SIZE],
            fit.simulator,
            noise,
            settings,
        )

    @property
    def horizons(self) -> Floats:
        """(H,) s."""
        return np.array(self.settings.verify.horizons)

    def forecast(self, simulator: Simulator, spin: float, shots: Shots) -> "Forecast":
        """Return the errors of a simulator's predictions of these shots, measured or corrected.

        ``spin``, in rad/s, is the size of a component of a spin: the prior of one without a label.
        """
        true = landings(self.simulator, self.states, _durations(shots))
        return _forecast(shots, true, simulator, self.noise, spin, self.settings)

    def squares(self, simulator: Simulator, spin: float, shots: Shots) -> Floats:
        """Return (B, H) mean square errors at the horizons, m^2, NaN where a shot has none."""
        return self.at_horizons(self.forecast(simulator, spin, shots).squares)

    def at_horizons(self, squares: Floats) -> Floats:
        """Return (B, H) means about the horizons of (B, N) squares at the samples."""
        return at_horizons(self.shots, squares, self.usable, self.horizons, self.settings)

    def errors(
        self, simulators: tuple[Simulator, Simulator], spins: tuple[float, float], after: Shots
    ) -> Errors:
        """Return the errors of the nominal simulator and of the amended one, and the floor.

        ``after`` are the shots as the amended simulator's sensor sees them, measured or corrected.
        """
        forecasts = [
            self.forecast(simulators[0], spins[0], self.shots),
            self.forecast(simulators[1], spins[1], after),
            _floor(self.shots, self.states, simulators[1], self.noise, spins[1], self.settings),
        ]
        landed = np.stack([forecast.landings for forecast in forecasts])
        landed[:, ~np.isfinite(landed).all(axis=(0, 2))] = np.nan
        squares = [self.at_horizons(forecast.squares) for forecast in forecasts]
        return Errors(self.horizons, np.stack(squares), landed)


def gap(found: Errors, settings: GapSettings) -> Gap | None:
    """Return the errors over the horizon and at landing, and the share of the gap that closed."""
    reached = np.isfinite(found.squares[0]).sum(axis=0) >= settings.verify.min_shots
    if not reached.any():
        return None
    squares, level = found.squares[..., reached], settings.confidence
    sizes, drawn = root_mean_squares(squares), _drawn(squares, settings)
    before, after, floor = (_thousandths(values) for values in sizes)
    share = float(_closed(sizes))
    return Gap(
        horizons_ms=tuple(round(1000 * h) for h in found.horizons[reached]),
        before_mm=before,
        after_mm=after,
        floor_mm=floor,
        removable_closed=share if np.isfinite(share) else None,
        removable_closed_interval=interval(_closed(drawn), level) if np.isfinite(share) else None,
        landing=_landing(found, settings),
        before_interval_mm=tuple(interval(row, level) for row in 1e3 * drawn[:, 0].T),
        after_interval_mm=tuple(interval(row, level) for row in 1e3 * drawn[:, 1].T),
        reduction_mm=interval(1e3 * _reduction(drawn), level),
    )


def _landing(found: Errors, settings: GapSettings) -> Landing | None:
    squares = found.landings[:, np.isfinite(found.landings).all(axis=(0, 2))]
    if squares.shape[1] < settings.verify.min_shots:
        return None
    sizes, drawn = root_mean_squares(squares), _drawn(squares, settings)
    return Landing(
        shots=squares.shape[1],
        **{
            f"{name}_{unit}": value
            for name, row in zip(("before", "after", "floor"), sizes, strict=True)
            for unit, value in zip(("mm", "ms"), _thousandths(row), strict=True)
        },
        reduction_mm=interval(1e3 * _reduction(drawn[..., :1]), settings.confidence),
        reduction_ms=interval(1e3 * _reduction(drawn[..., 1:]), settings.confidence),
    )


def _drawn(squares: Floats, settings: GapSettings) -> Floats:
    return resampled(squares, settings.verify.bootstrap_draws)


def _reduction(sizes: Floats) -> Floats:
    """Return the mean reduction of errors (..., 3, H) before, after and at the floor."""
    reduction: Floats = (sizes[..., 0, :] - sizes[..., 1, :]).mean(axis=-1)
    return reduction


def _closed(sizes: Floats) -> Floats:
    """Return the ratio of sums over horizons of (..., 3, H) errors before, after and at the floor.

    It is NaN where there is nothing to close.
    """
    before, after, floor = np.moveaxis(sizes.sum(axis=-1), -1, 0)
    removable = np.where(before > floor, before - floor, np.nan)
    closed: Floats = (before - after) / removable
    return closed


@dataclass(frozen=True)
class Forecast:
    """Squares of the errors of forecasts of B shots, NaN where there are none.

    Attributes:
        squares: (B, N) m^2 at the samples.
        landings: (B, 2) m^2 and s^2 at landing.
        missed: (B,) shots that are forecast to land and do not, or the other way round.
    """

    squares: Floats
    landings: Floats
    missed: Bools


def _forecast(
    shots: Shots,
    true: Landings,
    simulator: Simulator,
    noise: Noise,
    spin: float,
    settings: GapSettings,
) -> Forecast:
    states = _launches(shots, simulator, noise, spin, settings)
    prediction = predict_measurements(simulator, Schedule.of(shots), states)
    squares = ((shots.positions - prediction.positions) ** 2).sum(axis=2)
    forecast = landings(simulator, states, _durations(shots) + settings.verify.landing_horizon)
    missed = np.isfinite(forecast.times) != np.isfinite(true.times)
    return Forecast(squares, forecast.distances(true) ** 2, missed)


def _floor(
    shots: Shots,
    states: Floats,
    simulator: Simulator,
    noise: Noise,
    spin: float,
    settings: GapSettings,
) -> Forecast:
    """Return the errors of a correct simulator: means over replicates of the shots."""
    random = np.random.default_rng(0)
    true = landings(simulator, states, _durations(shots) + settings.verify.landing_horizon)
    replicates = [
        simulate_replicate(shots, simulator, states, noise, settings.fit.max_kicks, random)
        for _ in range(settings.verify.replicates)
    ]
    tries = [_forecast(one, true, simulator, noise, spin, settings) for one in replicates]
    missed = np.stack([one.missed for one in tries])
    return Forecast(
        _means_of_others(np.stack([one.squares for one in tries]), missed),
        _means_of_others(np.stack([one.landings for one in tries]), missed),
        np.asarray(missed.all(axis=0), dtype=np.bool_),
    )


def _means_of_others(values: Floats, left_out: Bools) -> Floats:
    """Return (B, N) means of (R, B, N) values that are not left out, NaN where all are."""
    kept = ~left_out[..., None]
    count = kept.sum(axis=0)
    means: Floats = np.where(kept, values, 0.0).sum(axis=0) / np.where(count > 0, count, np.nan)
    return means


def _launches(
    shots: Shots, simulator: Simulator, noise: Noise, spin: float, settings: GapSettings
) -> Floats:
    """Return the (B, 9) states that fit the first samples."""
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
