"""Tables of forecast errors: over the horizon, by group of recordings, between predictors."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from rallygap.models.predictors.errors import HORIZONS_MS, QUANTITIES, error_norms, error_statistics
from rallygap.models.predictors.protocol import Bools, Floats, Forecast
from rallygap.models.predictors.windows import Windows

SHOWN_HORIZONS_MS = (100, 200, 300)
MEASURED, TRUTH = "measured", "truth"  # what forecasts are compared with
STATISTICS = ["mean", "median", "ci_low", "ci_high", "n"]


@dataclass(frozen=True)
class ForecastErrors:
    """The errors of every predictor on the same windows.

    Every interval is bootstrapped from the same seed, so all predictors have the same resamples.

    Attributes:
        errors: predictor to quantity to (B, H) errors, NaN where nothing was measured.
        recordings: (B,) the recording of each window.
        bounced: (B,) whether the ball bounced on the table within the forecast.
        resamples: of the recordings, for the 95 % intervals.
        seed: of the resamples.
    """

    errors: dict[str, dict[str, Floats]]
    recordings: np.ndarray
    bounced: Bools
    resamples: int
    seed: int

    def over_horizon(self) -> pd.DataFrame:
        """Return one row a predictor, quantity, kind of window (``bounce``) and horizon."""
        kinds = {"all": np.full(len(self.bounced), True)}
        kinds |= {"with": self.bounced, "without": ~self.bounced}
        frames = {
            (predictor, quantity, kind): self._spread(error[chosen], chosen)
            for predictor, quantities in self.errors.items()
            for quantity, error in quantities.items()
            for kind, chosen in kinds.items()
        }
        return concat_tables(frames, ["predictor", "quantity", "bounce"])

    def by_group(self, groups: np.ndarray) -> pd.DataFrame:
        """Return the position error at the last horizon, one row a group and predictor.

        Args:
            groups: (B,) the group of each window's recording.
        """
        frames = {
            (group, predictor): self._spread(
                quantities["position"][groups == group], groups == group
            )
            for group in dict.fromkeys(groups)
            for predictor, quantities in self.errors.items()
        }
        rows = concat_tables(frames, ["group", "predictor"])
        last = rows["horizon_ms"] == HORIZONS_MS[-1]
        return rows.loc[last, ["group", "predictor", *STATISTICS]]

    def differences(self, predictors: list[str]) -> pd.DataFrame:
        """Return the paired differences between the errors of ``predictors`` and of all others.

        Differences are taken window by window. Two of ``predictors`` are compared once.

        Args:
            predictors: the minuends.

        Returns:
            One row a pair, quantity and horizon: ``mean`` of the difference with its interval, and
            ``lower_share``, the share of all horizons at which the predictor's mean is the lower.
        """
        others = [name for name in self.errors if name not in predictors]
        pairs = [
            (name, other)
            for k, name in enumerate(predictors)
            for other in [*others, *predictors[k + 1 :]]
        ]
        everything = np.full(len(self.recordings), True)
        frames = {}
        for name, other in pairs:
            for quantity in QUANTITIES:
                away = self.errors[name][quantity] - self.errors[other][quantity]
                spread = self._spread(away, everything)
                lower_share = (spread["mean"] < 0).mean()
                frames[name, other, quantity] = spread.assign(lower_share=lower_share)
        rows = concat_tables(frames, ["predictor", "other", "quantity"])
        return rows[rows["horizon_ms"].isin(SHOWN_HORIZONS_MS)].drop(columns=["median", "std"])

    def _spread(self, error: Floats, chosen: Bools) -> pd.DataFrame:
        """Return one row a horizon with any measurement, over the chosen windows."""
        generator = np.random.default_rng(self.seed)
        result = error_statistics(error, self.recordings[chosen], self.resamples, generator)
        table = pd.DataFrame({"horizon_ms": HORIZONS_MS, **vars(result)})
        names = {"count": "n", "low": "ci_low", "high": "ci_high"}
        return table.rename(columns=names)[result.count > 0]


def forecast_errors(
    forecasts: dict[str, Forecast], windows: Windows
) -> dict[str, dict[str, Floats]]:
    """Return predictor to quantity to (B, H) errors of forecasts of the same windows."""
    return {
        name: {quantity: error_norms(forecast, windows, quantity) for quantity in QUANTITIES}
        for name, forecast in forecasts.items()
    }


def concat_tables(frames: Mapping[Any, pd.DataFrame], names: list[str]) -> pd.DataFrame:
    """Return the concatenation of tables, with their keys as the first columns.

    Args:
        frames: key, a tuple of strings, to table; at least one.
        names: of the keys' columns.
    """
    return pd.concat(frames, names=names).reset_index(names).reset_index(drop=True)
