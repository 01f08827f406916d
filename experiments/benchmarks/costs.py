"""What predictors cost: training time, and latency for one ball on one core.

``python -m experiments.benchmarks.costs``, after ``make reproduce``.
"""

import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from experiments.benchmarks.comparison import ROOT, one_core, write_measured
from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS
from rallygap.models.predictors.protocol import History, Predictor
from rallygap.pipeline.evaluation.evaluation_windows import read_test_sets
from rallygap.pipeline.evaluation.predictors import NamedPredictor, read_predictors
from rallygap.pipeline.io.artifacts import read_table
from rallygap.pipeline.params import load_params
from rallygap.pipeline.runtime.progress import progress
from rallygap.pipeline.runtime.scratch import kept_timings

CALLS, WARM_UP = 500, 50
ERRORS = "artifacts/evaluate_predictor/report/errors.parquet"
ERROR_COLUMNS = [f"position_error_mm_{horizon}ms" for horizon in SHOWN_HORIZONS_MS]


def measure_costs(root: Path) -> pd.DataFrame:
    """Measure every predictor on the first set of a finished run in a repository.

    Returns:
        One row a predictor: its parameters, position errors (mm), seconds of training, median and
        99th percentile (ms) of the time of one forecast.
    """
    settings = load_params(root / "params.yaml").evaluate_predictor
    first = read_test_sets(root / "artifacts", settings.window_every_ms / 1000)[0]
    predictors = [
        predictor
        for predictor in read_predictors(root / "artifacts", settings)
        if predictor.forecasts(first.name)
    ]
    errors = read_table(root / ERRORS)
    errors = errors[errors["set"] == first.name].query(
        "against == 'measured' and quantity == 'position' and bounce == 'all'"
    )
    position_errors = errors.pivot_table("mean", "predictor", "horizon_ms")
    timings = kept_timings(root, "train_predictor")
    training = {
        name: timing["training_s"]
        for name, timing in timings.items()
        if isinstance(timing, dict) and "training_s" in timing
    }
    history = first.windows.history
    evenly = np.linspace(0, len(history) - 1, CALLS).astype(int)
    histories = [history[row : row + 1] for row in evenly]
    with one_core():
        latencies = {
            named.name: latency(named.predictor, histories)
            for named in progress(predictors, "latency", len(predictors))
        }
    rows = [_row(named, position_errors, training, latencies[named.name]) for named in predictors]
    return pd.DataFrame(rows).astype({"parameters": "Int64", "training_s": "Float64"})


def latency(predictor: Predictor, histories: list[History]) -> np.ndarray:
    """Return the duration (ms) of the forecast of each history, after a warm-up."""
    for history in histories[:WARM_UP]:
        predictor.predict(history)
    times = []
    for history in histories:
        start = time.perf_counter()
        predictor.predict(history)
        times.append(1000 * (time.perf_counter() - start))
    return np.array(times)


def _row(
    named: NamedPredictor, errors: pd.DataFrame, training: dict[str, float], times: np.ndarray
) -> dict[str, Any]:
    known = errors.reindex(index=[named.name], columns=list(SHOWN_HORIZONS_MS)).to_numpy()[0]
    return {
        "predictor": named.name,
        "parameters": named.parameters,
        **dict(zip(ERROR_COLUMNS, known, strict=True)),
        "training_s": training.get(named.name),
        "latency_ms_median": float(np.median(times)),
        "latency_ms_p99": float(np.quantile(times, 0.99)),
    }


if __name__ == "__main__":
    write_measured("costs", measure_costs(ROOT))
