"""Simulators that are amended in parallel, each a file, so that a killed run resumes."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from rallygap.models.ball.simulator import Simulator
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.io.simulators import load_simulator, simulator_yaml
from rallygap.pipeline.runtime.parallel import make_missing


def amended_simulators(
    amend: Mapping[str, Callable[[], Simulator]], folder: Path
) -> dict[str, Simulator]:
    """Return simulators by name; those whose file is in the folder are not amended again.

    Args:
        amend: by name, what returns an amended simulator; it can be pickled.
        folder: of the files.
    """
    files = {name: folder / f"{name}.yaml" for name in amend}
    tasks = {files[name]: partial(_write, files[name], task) for name, task in amend.items()}
    make_missing(tasks, "amended simulators")
    return {name: load_simulator(str(file)) for name, file in files.items()}


def _write(file: Path, amend: Callable[[], Simulator]) -> None:
    write_text(file, simulator_yaml(amend()))
