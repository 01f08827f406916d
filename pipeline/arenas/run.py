"""The experiment ``make arenas``: two and a half hours on two cores; writes ``reports/arenas``.

Twenty arenas of other seeds than that of params.yaml, so with other physics, cameras and players.
Training recordings of each amend simulator C and train networks, which forecast its test recordings
next to the oracle. A killed run resumes.
"""

from functools import partial
from pathlib import Path

import pandas as pd

from rallygap.pipeline.arenas.figure import arenas_figure
from rallygap.pipeline.arenas.world import arena_result
from rallygap.pipeline.experiments.experiment import running
from rallygap.pipeline.io.artifacts import read_json, write_json
from rallygap.pipeline.params import Params, load_params
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import make_missing
from rallygap.pipeline.runtime.paths import repository_root

SEEDS = [*range(101, 121)]


def arenas(root: Path) -> None:
    """Write causes and errors of all arenas, with the figure, to ``reports/arenas``.

    Raises:
        InputError: the experiment cannot start.
    """
    with running(root, "arenas.run") as run:
        params = load_params(root / "params.yaml")
        paths = {seed: run.scratch / f"{seed}.json" for seed in SEEDS}
        tasks = {path: partial(_write, params, seed, path) for seed, path in paths.items()}
        make_missing(tasks, "arenas")
        each = {seed: read_json(path) for seed, path in paths.items()}
        tables = {name: _joined(each, name) for name in ("causes", "errors")}
        figures = {"arenas": arenas_figure(tables["causes"], tables["errors"])}
        run.publish("arenas", tables, figures, "arenas", {"seeds": SEEDS}, digits=6)


def _write(params: Params, seed: int, path: Path) -> None:
    found = arena_result(params, seed, path.parent)
    # JSON has no NaN.
    known = {name: one.astype(object).where(one.notna(), None) for name, one in found.items()}
    write_json(path, {name: table.to_dict("list") for name, table in known.items()})


def _joined(each: dict[int, dict[str, dict[str, list[object]]]], name: str) -> pd.DataFrame:
    parts = {seed: pd.DataFrame(one[name]) for seed, one in each.items()}
    return pd.concat(parts, names=["seed"]).reset_index("seed").infer_objects()


if __name__ == "__main__":
    try:
        arenas(repository_root())
    except InputError as error:
        refuse(error)
