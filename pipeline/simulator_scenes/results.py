"""Results of the parts of the experiment, which a killed run leaves to the next one."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from rallygap.pipeline.io.artifacts import read_json, write_json
from rallygap.pipeline.runtime.parallel import make_missing

Result = dict[str, Any]
Maker = Callable[[], Result]


def results(scratch: Path, makers: Mapping[str, Maker], description: str) -> dict[str, Result]:
    """Return what makers return, by name; those that an earlier run has called are not called.

    Args:
        scratch: folder of the results.
        makers: by name; they can be pickled, and what they return can be written as JSON.
        description: of the progress bar.
    """
    paths = {name: scratch / f"{name}.json" for name in makers}
    tasks = {paths[name]: partial(_write, make, paths[name]) for name, make in makers.items()}
    make_missing(tasks, description)
    return {name: read_json(path) for name, path in paths.items()}


def _write(make: Maker, path: Path) -> None:
    write_json(path, make())
