"""Scores of anyone's forecasts, beside those of our own predictors on the same windows."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from rich.table import Table

from models.predictors.evaluation import SHOWN_HORIZONS_MS, ForecastErrors, errors_of, stacked
from pipeline.artifacts import write_json
from pipeline.benchmark.forecasts import read_forecasts
from pipeline.benchmark.windows import run_sets
from pipeline.errors import InputError
from pipeline.forecast_errors import NUMBERS, REPORT, read_errors
from pipeline.metrics import place, rounded
from pipeline.params import Params

UNITS = {"position": "mm", "velocity": "m/s", "spin": "rad/s"}


@dataclass(frozen=True)
class Scores:
    """Errors of forecasts against the measured state.

    Attributes:
        name: of the file of forecasts.
        errors: its own: a row a set, quantity and horizon, with mean, std, n and 95 % interval.
        ours: of the run's predictors, at 100, 200 and 300 ms, on the same sets.
    """

    name: str
    errors: pd.DataFrame
    ours: pd.DataFrame


def score(root: Path, params: Params, path: Path) -> Scores:
    """Score forecasts of the last run's test windows as evaluate_predictor scores its own.

    Args:
        root: of the repository, with the artefacts and reports of a finished run.
        params: of that run.
        path: of the forecasts.

    Raises:
        InputError: the forecasts, an artefact or the report is missing or broken.
    """
    sets = run_sets(root, params)
    forecasts = read_forecasts(path, sets)
    frames = {
        (one.name,): ForecastErrors(
            errors_of({path.name: forecasts[one.name]}, one.windows),
            one.recordings,
            one.windows.bounced[:, -1],
            params.evaluate_predictor.bootstrap_resamples,
            params.seed,
        ).over_horizon()
        for one in sets
        if one.name in forecasts
    }
    errors = _of_all_windows(stacked(frames, ["set"]))
    return Scores(path.name, errors, _ours(root, errors))


def write_scores(path: Path, scores: Scores) -> None:
    """Write the scores as JSON: ``{set: {quantity: {horizon_ms: {mean, std, n, …}}}}``."""
    result: dict[str, Any] = {}
    for row in scores.errors.to_dict("records"):
        keys = (row["set"], row["quantity"], row["horizon_ms"])
        place(result, keys).update({name: rounded(row[name]) for name in NUMBERS})
    write_json(path, result)


def score_tables(scores: Scores) -> Iterator[Table]:
    """Yield a table for the terminal a set and quantity, narrow enough for 80 characters."""
    shown = scores.errors[scores.errors["horizon_ms"].isin(SHOWN_HORIZONS_MS)]
    both = pd.concat([shown, scores.ours])
    for (name, quantity), rows in both.groupby(["set", "quantity"], sort=False):
        title = f"{name}: mean error of the {quantity} ({UNITS[str(quantity)]})"
        yield _table(title, rows, scores.name)


def _table(title: str, rows: pd.DataFrame, own: str) -> Table:
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    table.add_column("predictor", no_wrap=True)
    for horizon in SHOWN_HORIZONS_MS:
        table.add_column(f"{horizon} ms", justify="right", no_wrap=True)
    for predictor, errors in rows.groupby("predictor", sort=False):
        cells = {row.horizon_ms: _cell(row) for row in errors.itertuples()}
        known = [cells.get(horizon, "–") for horizon in SHOWN_HORIZONS_MS]
        table.add_row(str(predictor), *known, style="bold" if predictor == own else None)
    return table


def _cell(row: Any) -> str:
    return f"{_digits(row.mean)} ({_digits(row.ci_low)}–{_digits(row.ci_high)})"


def _digits(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def _ours(root: Path, errors: pd.DataFrame) -> pd.DataFrame:
    """Read the errors of our predictors on the same windows."""
    report = read_errors(root)
    measured = report[(report["against"] == "measured") & report["set"].isin(errors["set"])]
    ours = _of_all_windows(measured)
    keys = ["set", "quantity", "horizon_ms"]
    both = ours.merge(errors, on=keys, suffixes=("", "_theirs"))
    if len(both) < len(ours) or (both["n"] != both["n_theirs"]).any():
        problem = "was made on other windows; run `dvc repro evaluate_predictor`"
        raise InputError(root / REPORT, problem)
    return ours


def _of_all_windows(errors: pd.DataFrame) -> pd.DataFrame:
    """Return the rows that bounces do not tell apart."""
    rows: pd.DataFrame = errors[errors["bounce"] == "all"]
    return rows[["set", "predictor", "quantity", "horizon_ms", *NUMBERS]]
