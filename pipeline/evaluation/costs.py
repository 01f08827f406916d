"""Costs of predictors on this machine: training time, and latency for one ball on one core.

Times are not reproducible, so no stage reports them: ``rallygap costs`` measures them and writes
``reports/costs``, to be committed by hand.
"""

import platform
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import psutil
import torch
from rich.table import Table

from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS
from rallygap.models.predictors.protocol import History, Predictor
from rallygap.pipeline.evaluation.error_table import read_errors
from rallygap.pipeline.evaluation.evaluation_windows import read_test_sets
from rallygap.pipeline.evaluation.predictors import NamedPredictor, read_predictors
from rallygap.pipeline.io.artifacts import write_csv, write_json
from rallygap.pipeline.params import load_params
from rallygap.pipeline.runtime.git import git_commit
from rallygap.pipeline.runtime.progress import progress
from rallygap.pipeline.runtime.scratch import kept_timings
from rallygap.pipeline.runtime.torch_threads import one_thread

CALLS, WARM_UP = 500, 50
ERROR_COLUMNS = [f"position_error_mm_{horizon}ms" for horizon in SHOWN_HORIZONS_MS]
HEADINGS = {
    "predictor": "predictor",
    "parameters": "parameters",
    **{
        name: f"mm at\n{horizon} ms"
        for name, horizon in zip(ERROR_COLUMNS, SHOWN_HORIZONS_MS, strict=True)
    },
    "training_s": "training\n(s)",
    "latency_ms_median": "median\n(ms)",
    "latency_ms_p99": "p99\n(ms)",
}


def measure_costs(root: Path) -> pd.DataFrame:
    """Measure every predictor on the first set of the stage evaluate_predictor.

    Args:
        root: of the repository, with the artefacts and reports of a finished run.

    Returns:
        One row a predictor: its parameters, position errors (mm) as reported, seconds of training,
        median and 99th percentile (ms) of the time of one forecast.

    Raises:
        InputError: an artefact or a report is missing or invalid.
    """
    settings = load_params(root / "params.yaml").evaluate_predictor
    first = read_test_sets(root / "artifacts", settings.window_every_ms / 1000)[0]
    predictors = [
        predictor
        for predictor in read_predictors(root / "artifacts", settings)
        if predictor.forecasts(first.name)
    ]
    errors = read_errors(root).query(
        "against == 'measured' and quantity == 'position' and bounce == 'all'"
    )
    of_set = errors[errors["set"] == first.name]
    position_errors = of_set.pivot_table("mean", "predictor", "horizon_ms")
    timings = kept_timings(root, root / "reports" / "train_predictor")
    training = {
        name: one["training_s"]
        for name, one in timings.items()
        if isinstance(one, dict) and "training_s" in one
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
    """Return the duration (ms) of each forecast, after a warm-up.

    Args:
        predictor: forecasts.
        histories: one ball each.
    """
    for history in histories[:WARM_UP]:
        predictor.predict(history)
    times = []
    for history in histories:
        start = time.perf_counter()
        predictor.predict(history)
        times.append(1000 * (time.perf_counter() - start))
    return np.array(times)


@contextmanager
def one_core() -> Iterator[None]:
    """Pin this process to one core, where the system supports it, and torch to one thread."""
    process = psutil.Process()
    cores = process.cpu_affinity() if hasattr(process, "cpu_affinity") else None
    if cores:
        process.cpu_affinity(cores[-1:])
    try:
        with one_thread():
            yield
    finally:
        if cores:
            process.cpu_affinity(cores)


def machine(root: Path) -> dict[str, Any]:
    """Return the machine and commit of the measurement."""
    return {
        "cpu": _cpu_model(),
        "cores": psutil.cpu_count(logical=False) or psutil.cpu_count(),
        "torch": torch.__version__,
        "commit": git_commit(root),
    }


def write_costs(folder: Path, costs: pd.DataFrame, measured_on: dict[str, Any]) -> None:
    """Write costs.csv, with four digits, and costs.json with the machine."""
    write_csv(folder / "costs.csv", costs, digits=4)
    write_json(folder / "costs.json", measured_on)


def costs_table(costs: pd.DataFrame) -> Table:
    """Return the costs as a table for the terminal, narrow enough for 80 characters."""
    title = "Position error, training, and one ball at a time on one core"
    table = Table(title=title, box=None, pad_edge=False, collapse_padding=True)
    for name, heading in HEADINGS.items():
        table.add_column(
            heading, justify="left" if name == "predictor" else "right", overflow="fold"
        )
    for row in costs[list(HEADINGS)].itertuples(index=False):
        table.add_row(*map(_cell, row))
    return table


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


def _cpu_model() -> str:
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor()


def _cell(value: Any) -> str:
    if pd.isna(value):
        return "–"
    if isinstance(value, float):
        return f"{value:,.2f}" if value < 100 else f"{value:,.0f}"
    return value if isinstance(value, str) else f"{value:,}"
