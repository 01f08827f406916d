"""Uncertainty of forecasts: coverage and size of prediction regions, and CRPS."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice

import numpy as np
import pandas as pd

from rallygap.models.predictors.calibration import LEVELS, Calibration, Errors, crps
from rallygap.models.predictors.errors import EVALUATED, HORIZONS_MS, error_statistics
from rallygap.models.predictors.evaluation import concat_tables
from rallygap.models.predictors.protocol import Floats, ProbabilisticPredictor
from rallygap.models.predictors.windows import Windows
from rallygap.pipeline.evaluation.evaluation_windows import MeasuredSet
from rallygap.pipeline.evaluation.predictors import NamedPredictor
from rallygap.pipeline.runtime.parallel import parallel

BATCH = 256  # windows
MM = 1e3  # in a metre
COLUMNS = ["horizon_ms", "coverage", "ci_low", "ci_high", "size_mm", "crps_mm", "n"]


@dataclass(frozen=True)
class Coverage:
    """Calibrated prediction regions of B forecasts at H horizons; NaN where not measured.

    Attributes:
        covered: (L, B, H) 1 where a region contains the measured position.
        sizes: (L, B, H) m, radii of balls with the volumes of the regions.
        scores: (B, H) m, CRPS.
    """

    covered: Floats
    sizes: Floats
    scores: Floats

    @classmethod
    def of(cls, calibration: Calibration, errors: Errors) -> "Coverage":
        """Return the coverage of forecasts by their errors."""
        covered, sizes = calibration.covered(errors), calibration.sizes(errors)
        return cls(covered, sizes, crps(errors, calibration))

    @classmethod
    def crossed(cls, parts: Sequence[Errors]) -> "Coverage":
        """Return the coverage of all parts, each with regions that the other parts calibrate."""
        others = [joined_errors([*parts[:k], *parts[k + 1 :]]) for k in range(len(parts))]
        pairs = zip(others, parts, strict=True)
        crossed = [cls.of(Calibration.of(rest), part) for rest, part in pairs]
        covered, sizes, scores = (
            np.concatenate([getattr(part, name) for part in crossed], axis=-2)
            for name in ("covered", "sizes", "scores")
        )
        return cls(covered, sizes, scores)

    def table(self, recordings: np.ndarray, resamples: int, seed: int) -> pd.DataFrame:
        """Return one row a level and horizon, with intervals by a bootstrap over recordings.

        Args:
            recordings: (B,) of the forecasts.
            resamples: of these.
            seed: of the draws.

        Returns:
            Columns level, horizon_ms, coverage with ci_low and ci_high, size_mm, crps_mm, n.
        """
        frames = {}
        for level, covered, sizes in zip(LEVELS, self.covered, self.sizes, strict=True):
            generator = np.random.default_rng(seed)
            shares = error_statistics(covered, recordings, resamples, generator)
            known = np.isfinite(covered)
            columns = {
                "horizon_ms": HORIZONS_MS,
                "coverage": shares.mean,
                "ci_low": shares.low,
                "ci_high": shares.high,
                "size_mm": MM * _mean(sizes, known),
                "crps_mm": MM * _mean(self.scores, known),
                "n": shares.count,
            }
            frames[level,] = pd.DataFrame(columns)[shares.count > 0]
        return concat_tables(frames, ["level"])


def coverage_rows(
    test: MeasuredSet,
    validation: MeasuredSet,
    predictors: Sequence[NamedPredictor],
    resamples: int,
    seed: int,
) -> pd.DataFrame:
    """Return what the regions of each predictor cover, one row a predictor, level and horizon.

    Regions are calibrated by the validation windows, and tested on the test windows.

    Args:
        test: of the source.
        validation: of the same source.
        predictors: with covariances.
        resamples: of recordings, for the 95 % intervals.
        seed: of these.
    """
    batches = [_batches(part.windows) for part in (validation, test)]
    tasks = [
        partial(_errors_of_batch, named.predictor, batch)
        for named in predictors
        for part in batches
        for batch in part
    ]
    results = parallel(tasks, f"uncertainty on {test.name}")
    frames = {}
    for named in predictors:
        known, new = (joined_errors(list(islice(results, len(part)))) for part in batches)
        coverage = Coverage.of(Calibration.of(known), new)
        frames[(named.name,)] = coverage.table(test.recordings, resamples, seed)
    return concat_tables(frames, ["predictor"])


def errors_of(predictor: ProbabilisticPredictor, windows: Windows) -> Errors:
    """Return the errors at the horizons ``HORIZONS_MS``."""
    return joined_errors([_errors_of_batch(predictor, batch) for batch in _batches(windows)])


def joined_errors(parts: Sequence[Errors]) -> Errors:
    """Return the errors of several parts as one."""
    away = np.concatenate([part.away for part in parts])
    return Errors(away, np.concatenate([part.covariances for part in parts]))


def _errors_of_batch(predictor: ProbabilisticPredictor, windows: Windows) -> Errors:
    errors = Errors.of(*predictor.predict_with_covariances(windows.history), windows)
    return Errors(errors.away[:, EVALUATED], errors.covariances[:, EVALUATED])


def _batches(windows: Windows) -> list[Windows]:
    return [windows[k : k + BATCH] for k in range(0, len(windows), BATCH)]


def _mean(values: Floats, known: np.ndarray) -> Floats:
    sums = np.where(known, values, 0.0).sum(axis=0)
    return sums / np.maximum(known.sum(axis=0), 1)
