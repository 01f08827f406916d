"""Forecasts as a participant writes them: from the exported table alone."""

import numpy as np
import pandas as pd

from rallygap.models.predictors.errors import EVALUATED, HORIZONS_MS
from rallygap.models.predictors.protocol import FUTURE, HISTORY, Forecast, History
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, STATE_COLUMNS


def forecasts_of(predictor, exported: pd.DataFrame) -> pd.DataFrame:
    """Return a predictor's forecasts of exported windows, as a table."""
    rows = exported.sort_values(["window_id", "t"])
    seen = rows[[*POSITION_COLUMNS, *SPIN_COLUMNS]].to_numpy().reshape(-1, HISTORY, 6)
    mask = ~np.isnan(seen)
    states = predictor.predict(History(np.where(mask, seen, 0.0), mask)).states[:, EVALUATED]
    table = pd.DataFrame(states.reshape(-1, 9), columns=STATE_COLUMNS)
    names = rows["window_id"].unique()
    table["window_id"] = np.repeat(names, len(HORIZONS_MS))
    table["horizon_ms"] = np.tile(HORIZONS_MS, len(names))
    return table


class ZeroPredictor:
    """Forecasts zero states."""

    def predict(self, history):
        return Forecast(np.zeros((len(history), FUTURE, 9)), np.ones(len(history), bool))
