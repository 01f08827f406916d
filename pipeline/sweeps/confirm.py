"""Confirms a sweep: full trainings with params.yaml and the best parameters, on unseen shots."""

import hashlib
import json
import shutil

import pandas as pd
from rich.table import Table

from rallygap.pipeline.io.artifacts import write_csv, write_json
from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.params import Params, as_json, check_params, read_yaml, with_current_keys
from rallygap.pipeline.profiles import merged
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import short
from rallygap.pipeline.sweeps.comparison import SEEDS
from rallygap.pipeline.sweeps.report import BEST, CONFIRMED, CONFIRMED_SUMMARY
from rallygap.pipeline.sweeps.settings import PredictorSweep, Sweep


def run_confirm(sweep: Sweep) -> pd.DataFrame | None:
    """Train with params.yaml and with the best parameters, with seeds and shots new to both.

    A killed run resumes. params.yaml does not change.

    Returns:
        The table of ``comparison``, also written to ``reports/sweeps/NAME``; none, and nothing is
        trained, if params.yaml has the best parameters.

    Raises:
        InputError: the sweep was not run.
    """
    settings = compared_params(sweep)
    if settings[0] == settings[1]:
        return None
    content = json.dumps([sweep.study, *(params.model_dump(mode="json") for params in settings)])
    folder = sweep.scratch / "confirm" / short(hashlib.sha256(content.encode()).hexdigest())
    if isinstance(sweep.settings, PredictorSweep):
        from rallygap.pipeline.sweeps.predictor import compare_predictors

        table = compare_predictors(sweep.root, sweep.settings, settings, folder)
    else:
        from rallygap.pipeline.sweeps.policy import compare_policies

        table = compare_policies(sweep.settings, settings, folder)
    write_csv(sweep.report / CONFIRMED, table)
    first = table.iloc[0].to_dict()
    numbers = ("params", "found", "difference", "ci_low", "ci_high")
    summary = {
        "sweep": sweep.name,
        "measure": first["measure"],
        **{name: rounded(first[name]) for name in numbers},
        "per_seed": [rounded(first[f"seed_{k + 1}"]) for k in range(SEEDS)],
        "n": first["n"],
        "holds": bool(first["holds"]),
    }
    write_json(sweep.report / CONFIRMED_SUMMARY, summary)
    shutil.rmtree(sweep.scratch / "confirm", ignore_errors=True)
    return table


def compared_params(sweep: Sweep) -> list[Params]:
    """Return the parameters of params.yaml, and the same with the best of the sweep.

    Raises:
        InputError: the sweep was not run, or its file is invalid.
    """
    path = sweep.report / BEST
    if not path.is_file():
        raise InputError(path, f"there is no such file; run `rallygap sweep {sweep.name}`")
    plain = json.loads(as_json(read_yaml(path), path))  # no alias that holds itself
    best = merged(sweep.params, with_current_keys(plain))
    return [check_params(content, path) for content in (sweep.params, best)]


def confirmed_table(table: pd.DataFrame) -> Table:
    """Return the comparison as a table for the terminal."""
    shown = Table(box=None, pad_edge=False, title="Best parameters of the sweep and params.yaml")
    for heading in ("", "params.yaml", "sweep", "difference", "95 % interval", "holds"):
        shown.add_column(heading, justify="right" if heading else "left", overflow="fold")
    for row in table.to_dict("records"):
        numbers = (f"{row[name]:.4g}" for name in ("params", "found", "difference"))
        interval = f"{row['ci_low']:.3g} to {row['ci_high']:.3g}"
        shown.add_row(row["measure"], *numbers, interval, "yes" if row["holds"] else "no")
    return shown
