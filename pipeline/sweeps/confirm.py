"""Whether what a sweep found holds: full trainings with other seeds, on balls it never saw."""

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import pandas as pd
from rich.table import Table

from pipeline.experiments.profiles import merged
from pipeline.io.artifacts import write_csv, write_json
from pipeline.io.metrics import rounded
from pipeline.params import Params, check_params, read_yaml
from pipeline.runtime.errors import InputError
from pipeline.runtime.provenance import short
from pipeline.sweeps.paired_comparison import SEEDS, Judged
from pipeline.sweeps.plan import Plan
from pipeline.sweeps.report import BEST, CONFIRMED, CONFIRMED_SUMMARY
from pipeline.sweeps.settings import PredictorSweep


def run_confirm(plan: Plan) -> pd.DataFrame:
    """Train the parameters as they are and those found, with seeds and balls new to both.

    A run that was killed goes on where it was. Nothing of params.yaml changes.

    Returns:
        The table of ``Judged``, also written to ``reports/sweeps/<name>``.

    Raises:
        InputError: the sweep has not been run, or params.yaml says already what it found.
    """
    both = compared_params(plan)
    folder = plan.scratch / "confirm" / _fingerprint(plan, both)
    table = _judged(plan, both, folder).table(plan.params["seed"])
    write_csv(plan.report / CONFIRMED, table)
    write_json(plan.report / CONFIRMED_SUMMARY, _summary(plan, table))
    shutil.rmtree(plan.scratch / "confirm", ignore_errors=True)
    return table


def compared_params(plan: Plan) -> list[Params]:
    """Return the parameters as they are and with what the sweep found.

    Raises:
        InputError: the sweep has not been run, its file is broken, or params.yaml says the same.
    """
    path = plan.report / BEST
    if not path.is_file():
        raise InputError(path, f"there is no such file; run `rallygap sweep {plan.name}`")
    both = [
        check_params(plan.params, path),
        check_params(merged(plan.params, read_yaml(path)), path),
    ]
    if both[0] == both[1]:
        raise InputError(path, "says what params.yaml says already: there is nothing to confirm")
    return both


def _fingerprint(plan: Plan, both: list[Params]) -> str:
    content = json.dumps([plan.fingerprint, *(one.model_dump(mode="json") for one in both)])
    return short(hashlib.sha256(content.encode()).hexdigest())


def _judged(plan: Plan, both: list[Params], folder: Path) -> Judged:
    if isinstance(plan.settings, PredictorSweep):
        from pipeline.sweeps.predictor_comparison import judged_predictors

        return judged_predictors(plan.root, plan.settings, both, folder)
    from pipeline.sweeps.policy_comparison import judged_policies

    return judged_policies(plan.settings, both, folder)


def _summary(plan: Plan, table: pd.DataFrame) -> dict[str, Any]:
    decisive = table.iloc[0].to_dict()
    numbers = ("params", "found", "difference", "ci_low", "ci_high")
    return {
        "sweep": plan.name,
        "measure": decisive["measure"],
        **{name: rounded(decisive[name]) for name in numbers},
        "per_seed": [rounded(decisive[f"seed_{k + 1}"]) for k in range(SEEDS)],
        "n": decisive["n"],
        "holds": bool(decisive["holds"]),
    }


def confirmed_table(table: pd.DataFrame) -> Table:
    """Return the comparison as a table for the terminal."""
    shown = Table(box=None, pad_edge=False, title="What the sweep found, beside params.yaml")
    for heading in ("", "params", "found", "difference", "95 % interval", "holds"):
        shown.add_column(heading, justify="right" if heading else "left", overflow="fold")
    for row in table.to_dict("records"):
        numbers = (f"{row[name]:.4g}" for name in ("params", "found", "difference"))
        interval = f"{row['ci_low']:.3g} to {row['ci_high']:.3g}"
        shown.add_row(row["measure"], *numbers, interval, "yes" if row["holds"] else "no")
    return shown
