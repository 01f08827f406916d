"""Predictors and the gap workflow on twenty fresh arenas; two and a half hours on two cores.

Twenty arenas of other seeds than that of params.yaml, so with other physics, cameras and players.
Training recordings of each amend simulator C and train networks, which forecast its test recordings
next to the oracle.
"""

from functools import partial
from pathlib import Path

import pandas as pd

from rallygap.pipeline.experiments.arenas.world import arena_result
from rallygap.pipeline.io.artifacts import read_json, write_json
from rallygap.pipeline.params import Params
from rallygap.pipeline.runtime.parallel import make_missing
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

SEEDS = [*range(101, 121)]


def arenas(run: StageRun) -> None:
    """Write causes and errors of all arenas."""
    paths = {seed: run.scratch(f"{seed}.json") for seed in SEEDS}
    tasks = {path: partial(_write, run.params, seed, path) for seed, path in paths.items()}
    make_missing(tasks, "arenas")
    results = {seed: read_json(path) for seed, path in paths.items()}
    causes, errors = (_joined(results, name) for name in ("causes", "errors"))
    run.publish({"causes": causes, "errors": errors}, digits=6)


def _write(params: Params, seed: int, path: Path) -> None:
    found = arena_result(params, seed, path.parent)
    # JSON has no NaN.
    known = {name: one.astype(object).where(one.notna(), None) for name, one in found.items()}
    write_json(path, {name: table.to_dict("list") for name, table in known.items()})


def _joined(results: dict[int, dict[str, dict[str, list[object]]]], name: str) -> pd.DataFrame:
    parts = {seed: pd.DataFrame(one[name]) for seed, one in results.items()}
    return pd.concat(parts, names=["seed"]).reset_index("seed").infer_objects()


if __name__ == "__main__":
    run_stage(arenas)
