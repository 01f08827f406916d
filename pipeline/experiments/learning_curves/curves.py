"""Learning curves from errors: by number of recordings, over draws."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from rallygap.models.predictors.protocol import Floats
from rallygap.models.support.clustered_means import clustered_mean

KEYS = ["predictor", "recordings", "horizon_ms"]
COLUMNS = [*KEYS, "mean", "ci_low", "ci_high", "median", "of_oracle", "draws", "n"]
ORACLE = "oracle"


@dataclass(frozen=True)
class Errors:
    """Position errors of predictors of D draws on the same B windows.

    Attributes:
        predictor: what kind of predictor.
        recordings: that each has learned from.
        by_draw: (D, B, H) m, NaN where nothing was measured.
    """

    predictor: str
    recordings: int
    by_draw: Floats


def curve_rows(errors: list[Errors], tested: np.ndarray, horizons_ms: list[int]) -> pd.DataFrame:
    """Return one row a predictor, number of recordings and horizon.

    Means, in mm, are over draws and windows, their 95 % intervals over draws and test
    recordings.
    ``of_oracle`` is the mean divided by that of the oracle, ``median`` that of all windows and
    draws.

    Args:
        errors: the oracle's among them.
        tested: (B,) the test recording of each window.
        horizons_ms: of the errors.
    """
    oracle = next(_means(one) for one in errors if one.predictor == ORACLE)
    rows = [row for one in errors for row in _rows(one, tested, horizons_ms, oracle)]
    return pd.DataFrame(rows, columns=COLUMNS)


def _rows(
    one: Errors, tested: np.ndarray, horizons_ms: list[int], oracle: Floats
) -> Iterator[Mapping[str, float | str | int]]:
    found, medians = clustered_mean(one.by_draw, tested), np.nanmedian(one.by_draw, axis=(0, 1))
    for h, horizon in enumerate(horizons_ms):
        yield {
            "predictor": one.predictor,
            "recordings": one.recordings,
            "horizon_ms": horizon,
            "mean": 1e3 * found.mean[h],
            "ci_low": 1e3 * found.low[h],
            "ci_high": 1e3 * found.high[h],
            "median": 1e3 * medians[h],
            "of_oracle": found.mean[h] / oracle[h],
            "draws": len(one.by_draw),
            "n": int(np.isfinite(one.by_draw[0, :, h]).sum()),
        }


def _means(one: Errors) -> Floats:
    means: Floats = np.nanmean(one.by_draw, axis=(0, 1))
    return means
