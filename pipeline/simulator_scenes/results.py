"""Results of the parts of the experiment, which a killed run leaves to the next one."""

import shutil
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from pipeline.io.artifacts import read_json, write_json
from pipeline.runtime.parallel import make_missing
from pipeline.runtime.provenance import combined_hash, short

SCRATCH = Path("scratch") / "simulator_scenes"
DEPENDENCIES = ("models", "pipeline/engines", "pipeline/simulator_scenes")  # of results
REPORTS = Path("reports") / "simulators"

Result = dict[str, Any]
Maker = Callable[[], Result]


def results(root: Path, makers: Mapping[str, Maker], description: str) -> dict[str, Result]:
    """Return what makers return, by name; those that an earlier run has called are not called.

    Args:
        root: of the repository.
        makers: by name; they can be pickled, and what they return can be written as JSON.
        description: of the progress bar.
    """
    scratch = root / SCRATCH / short(combined_hash(root, DEPENDENCIES))
    paths = {name: scratch / f"{name}.json" for name in makers}
    tasks = {paths[name]: partial(_write, make, paths[name]) for name, make in makers.items()}
    make_missing(tasks, description)
    return {name: read_json(path) for name, path in paths.items()}


def forget(root: Path) -> None:
    """Remove what is kept for the next run."""
    shutil.rmtree(root / SCRATCH, ignore_errors=True)


def _write(make: Maker, path: Path) -> None:
    write_json(path, make())
