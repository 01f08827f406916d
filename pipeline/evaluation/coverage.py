"""How sure predictors are, and whether they may be: coverage and size of their sets, and CRPS."""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
import pandas as pd

from models.predictors.calibration import LEVELS, Calibration, Errors, crps
from models.predictors.errors import EVALUATED, HORIZONS_MS, error_statistics
from models.predictors.evaluation import SHOWN_HORIZONS_MS, concat_tables
from models.predictors.protocol import Floats, ProbabilisticPredictor
from models.predictors.windows import Windows
from pipeline.evaluation.figures.coverage import coverage_figure
from pipeline.evaluation.predictors import NamedPredictor
from pipeline.evaluation.test_windows import MeasuredSet
from pipeline.io.report_items import ReportFigure, ReportTable
from pipeline.runtime.parallel import parallel

BATCH = 256  # windows
MM = 1e3  # in a metre
COLUMNS = ["horizon_ms", "coverage", "ci_low", "ci_high", "size_mm", "crps_mm", "n"]


def coverage_rows(
    test: MeasuredSet,
    validation: MeasuredSet,
    predictors: Sequence[NamedPredictor],
    resamples: int,
    seed: int,
) -> pd.DataFrame:
    """Return what the sets of each predictor cover, one row a predictor, level and horizon.

    Sets are calibrated by the validation windows, and tested on the test windows.

    Args:
        test: of the source.
        validation: of the same source.
        predictors: that say how sure they are.
        resamples: of recordings, for the 95 % intervals.
        seed: of these.

    Returns:
        Columns predictor, level, horizon_ms, coverage with ci_low and ci_high, size_mm, crps_mm, n.
    """
    batches = [
        partial(_errors_of_batch, one.predictor, windows)
        for one in predictors
        for part in (validation, test)
        for windows in _batches(part.windows)
    ]
    found = iter(parallel(batches, f"uncertainty on {test.name}"))
    frames = {}
    for one in predictors:
        known, new = (
            _joined([next(found) for _ in _batches(part.windows)]) for part in (validation, test)
        )
        calibration = Calibration.of(known)
        for number, level in enumerate(LEVELS):
            frames[one.name, level] = _rows(
                calibration, new, number, test.recordings, resamples, seed
            )
    return concat_tables(frames, ["predictor", "level"])


def coverage_table(rows: Mapping[str, pd.DataFrame]) -> ReportTable:
    """Return the table at three horizons, by set; without validation windows it is empty."""
    tables = {(name,): one for name, one in rows.items()}
    none = pd.DataFrame(columns=["set", "predictor", "level", *COLUMNS])
    table = concat_tables(tables, ["set"]) if tables else none
    return ReportTable(
        table[table["horizon_ms"].isin(SHOWN_HORIZONS_MS)],
        "coverage",
        title="Sets of forecast positions at 100, 200 and 300 ms",
        caption="Share of measured positions inside the sets that are to contain 50 and 90 %, with "
        "its 95 % interval bootstrapped over recordings; the size of the sets in mm, the mean "
        "radius of balls of the same volume; and the continuous ranked probability score in mm, "
        "mean over the axes. The predictor gives the shape of a set; its radius follows from the "
        "errors on validation windows, at every horizon on its own.",
    )


def coverage_figures(rows: Mapping[str, pd.DataFrame]) -> list[ReportFigure]:
    """Return a figure for each set."""
    return [
        ReportFigure(
            coverage_figure(one),
            f"coverage_{name}",
            title=f"Coverage and size of sets on {name}",
            caption="Share of measured positions inside the sets that are to contain 50 and 90 % "
            "(dotted line), and their mean radius. The table has intervals.",
        )
        for name, one in rows.items()
    ]


def _errors_of_batch(predictor: ProbabilisticPredictor, windows: Windows) -> Errors:
    found = Errors.of(*predictor.predict_with_covariances(windows.history), windows)
    return Errors(found.away[:, EVALUATED], found.covariances[:, EVALUATED])


def _batches(windows: Windows) -> list[Windows]:
    return [windows[k : k + BATCH] for k in range(0, len(windows), BATCH)]


def _joined(parts: Sequence[Errors]) -> Errors:
    away = np.concatenate([one.away for one in parts])
    return Errors(away, np.concatenate([one.covariances for one in parts]))


def _rows(
    calibration: Calibration,
    errors: Errors,
    number: int,
    recordings: np.ndarray,
    resamples: int,
    seed: int,
) -> pd.DataFrame:
    """Return the rows of one level, by its number."""
    random = np.random.default_rng(seed)
    covered = calibration.covered(errors)[number]
    shares = error_statistics(covered, recordings, resamples, random)
    known = np.isfinite(covered)
    columns = (
        HORIZONS_MS,
        shares.mean,
        shares.low,
        shares.high,
        MM * _mean(calibration.sizes(errors)[number], known),
        MM * _mean(crps(errors, calibration), known),
        shares.count,
    )
    return pd.DataFrame(dict(zip(COLUMNS, columns, strict=True)))[shares.count > 0]


def _mean(values: Floats, known: np.ndarray) -> Floats:
    sums = np.where(known, values, 0.0).sum(axis=0)
    means: Floats = sums / np.maximum(known.sum(axis=0), 1)
    return means
