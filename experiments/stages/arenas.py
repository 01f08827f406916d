"""Predictors and the gap workflow on twenty fresh arenas; two and a half hours on two cores.

Twenty arenas of other seeds than that of params.yaml, so with other physics, cameras and players.
Training recordings of each amend simulator C and train networks, which forecast its test recordings
next to the oracle.
"""

from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from experiments.arenas import arena_result
from experiments.resumed import json_results
from rallygap.pipeline.params import Params
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

SEEDS = [*range(101, 121)]


def arenas(run: StageRun) -> None:
    """Write causes and errors of all arenas."""
    scratch = run.scratch(".")
    tasks = {
        scratch / f"{seed}.json": partial(_content, run.params, seed, scratch) for seed in SEEDS
    }
    results = dict(zip(SEEDS, json_results(tasks, "arenas"), strict=True))
    tables = {}
    for name in ("causes", "errors"):
        parts = {seed: pd.DataFrame(result[name]) for seed, result in results.items()}
        joined = pd.concat(parts, names=["seed"]).reset_index("seed")
        tables[name] = joined.infer_objects()
    run.publish(tables, digits=6)


def _content(params: Params, seed: int, scratch: Path) -> dict[str, Any]:
    """Return the tables of an arena as lists; JSON has no NaN."""
    return {
        name: table.astype(object).where(table.notna(), None).to_dict("list")
        for name, table in arena_result(params, seed, scratch).items()
    }


if __name__ == "__main__":
    run_stage(arenas)
