"""Scores of any forecasts, and of the predictors of the run on the same windows."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
from rich.table import Table

from rallygap.models.predictors.evaluation import (
    SHOWN_HORIZONS_MS,
    ForecastErrors,
    concat_tables,
    forecast_errors,
)
from rallygap.pipeline.benchmark.forecasts import read_forecasts
from rallygap.pipeline.benchmark.windows import run_sets
from rallygap.pipeline.evaluation.predictors import read_predictors
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.io.metrics import nested
from rallygap.pipeline.params import Params
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.progress import progress
from rallygap.pipeline.runtime.torch_threads import one_thread

UNITS = {"position": "mm", "velocity": "m/s", "spin": "rad/s"}


@one_thread()
def score(root: Path, params: Params, path: Path) -> pd.DataFrame:
    """Score forecasts of the last run's test windows, and its own predictors on the same windows.

    Args:
        root: of the repository, with the artefacts of a finished run.
        params: of that run.
        path: of the forecasts.

    Returns:
        Errors against the measured state: a row a set, predictor, quantity and horizon, with mean,
        std, n and 95 % interval. Of the predictors, the file of forecasts is the first.

    Raises:
        InputError: the forecasts or an artefact are missing or broken, or the forecasts are called
            as one of the run's predictors.
    """
    sets = run_sets(root, params)
    theirs = read_forecasts(path, sets)
    predictors = read_predictors(root / "artifacts", params.evaluate_predictor)
    if path.name in {predictor.name for predictor in predictors}:
        raise InputError(path, "is called as a predictor of the run; give it another name")
    frames = {}
    for measured in sets:
        if measured.name not in theirs:
            continue
        known = [predictor for predictor in predictors if predictor.forecasts(measured.name)]
        forecasts = {path.name: theirs[measured.name]}
        for named in progress(known, measured.name, len(known)):
            forecasts[named.name] = named.predictor.predict(measured.windows.history)
        errors = ForecastErrors(
            forecast_errors(forecasts, measured.windows),
            measured.recordings,
            measured.windows.bounced[:, -1],
            params.evaluate_predictor.bootstrap_resamples,
            params.seed,
        ).over_horizon()
        frames[(measured.name,)] = errors[errors["bounce"] == "all"].drop(columns="bounce")
    return concat_tables(frames, ["set"])


def write_scores(path: Path, errors: pd.DataFrame) -> None:
    """Write all as JSON: ``{set: {predictor: {quantity: {horizon_ms: {mean, std, n, …}}}}}``."""
    write_json(path, nested(errors, ["set", "predictor", "quantity", "horizon_ms"]))


def score_tables(errors: pd.DataFrame, own: str) -> Iterator[Table]:
    """Yield a table for the terminal a set and quantity, with one predictor in bold."""
    shown = errors[errors["horizon_ms"].isin(SHOWN_HORIZONS_MS)]
    for (name, quantity), rows in shown.groupby(["set", "quantity"], sort=False):
        title = f"{name}: mean error of the {quantity} ({UNITS[str(quantity)]})"
        table = Table(title=title, title_justify="left", box=None, pad_edge=False)
        table.add_column("predictor", overflow="fold")
        for horizon in SHOWN_HORIZONS_MS:
            table.add_column(f"{horizon} ms", justify="right", overflow="fold")
        for predictor, of_predictor in rows.groupby("predictor", sort=False):
            cells = {row.horizon_ms: _cell(row) for row in of_predictor.itertuples()}
            known = [cells.get(horizon, "–") for horizon in SHOWN_HORIZONS_MS]
            table.add_row(str(predictor), *known, style="bold" if predictor == own else None)
        yield table


def _cell(row: Any) -> str:
    mean, low, high = (
        f"{value:,.0f}" if value >= 100 else f"{value:.3g}"
        for value in (row.mean, row.ci_low, row.ci_high)
    )
    return f"{mean} ({low}–{high})"
