"""The experiment ``make arenas``: an hour on two cores; writes ``reports/arenas``.

Twenty arenas of other seeds than that of params.yaml, so with other physics, cameras and players.
Simulator C is amended by training recordings of each, and forecasts its test recordings next to the
oracle. A killed run resumes.
"""

import shutil
from functools import partial
from pathlib import Path

import pandas as pd

from pipeline.arenas.figure import arenas_figure
from pipeline.arenas.world import arena_result
from pipeline.evaluation.costs import machine
from pipeline.io.artifacts import read_json, write_csv, write_json
from pipeline.io.figure_style import apply_style, save_figure
from pipeline.params import Params, load_params
from pipeline.runtime.parallel import make_missing
from pipeline.runtime.paths import repository_root
from pipeline.runtime.provenance import combined_hash, short

SEEDS = range(101, 121)
REPORT = Path("reports") / "arenas"
SCRATCH = Path("scratch") / "arenas"
# What results depend on.
DEPENDENCIES = ("models", "pipeline/arenas", "pipeline/gap", "pipeline/segmentation", "params.yaml")


def arenas(root: Path) -> dict[str, pd.DataFrame]:
    """Write and return causes and errors of all arenas, with the figure and the machine."""
    params = load_params(root / "params.yaml")
    scratch = root / SCRATCH / short(combined_hash(root, DEPENDENCIES))
    paths = {seed: scratch / f"{seed}.json" for seed in SEEDS}
    tasks = {path: partial(_write, params, seed, path) for seed, path in paths.items()}
    make_missing(tasks, "arenas")
    each = {seed: read_json(path) for seed, path in paths.items()}
    tables = {name: _joined(each, name) for name in ("causes", "errors")}
    for name, table in tables.items():
        write_csv(root / REPORT / f"{name}.csv", table, digits=6)
    apply_style()
    save_figure(root / REPORT / "arenas.png", arenas_figure(tables["causes"], tables["errors"]))
    write_json(root / REPORT / "arenas.json", machine(root))
    shutil.rmtree(root / SCRATCH)
    return tables


def _write(params: Params, seed: int, path: Path) -> None:
    found = arena_result(params, seed, path.with_suffix(""))
    # JSON has no NaN.
    known = {name: one.astype(object).where(one.notna(), None) for name, one in found.items()}
    write_json(path, {name: table.to_dict("list") for name, table in known.items()})


def _joined(each: dict[int, dict[str, dict[str, list[object]]]], name: str) -> pd.DataFrame:
    parts = {seed: pd.DataFrame(one[name]) for seed, one in each.items()}
    return pd.concat(parts, names=["seed"]).reset_index("seed").infer_objects()


if __name__ == "__main__":
    arenas(repository_root())
