"""Results in parallel, each a file, so that a killed run resumes."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.verdict import Verdict, VerdictError
from rallygap.pipeline.io.artifacts import read_json, write_json, write_text
from rallygap.pipeline.io.simulators import load_simulator, simulator_yaml
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import make_missing


def json_results(tasks: Mapping[Path, Callable[[], Any]], description: str) -> list[Any]:
    """Return what tasks return, as JSON has it; those whose file is there are not done again.

    Args:
        tasks: by file, in a folder of a run of a stage.
        description: of the progress bar.

    Raises:
        InputError: a file that an earlier run left is no JSON.
    """
    make_missing({file: partial(_write, file, task) for file, task in tasks.items()}, description)
    return [read_json(file) for file in tasks]


def _write(file: Path, task: Callable[[], Any]) -> None:
    write_json(file, task())


def amended_simulators(
    amend: Mapping[str, Callable[[], Simulator]], folder: Path
) -> dict[str, Simulator]:
    """Return simulators by name; those whose file is in the folder are not amended again.

    Args:
        amend: by name, what returns an amended simulator; it can be pickled.
        folder: of the files.
    """
    files = {name: folder / f"{name}.yaml" for name in amend}
    tasks = {files[name]: partial(_write_amended, files[name], amend[name]) for name in amend}
    make_missing(tasks, "amended simulators")
    return {name: load_simulator(str(file)) for name, file in files.items()}


def _write_amended(file: Path, amend: Callable[[], Simulator]) -> None:
    write_text(file, simulator_yaml(amend()))


@dataclass(frozen=True)
class Diagnosis:
    """Shots, the nominal simulator to compare them with, and the file of the verdict."""

    file: Path
    shots: Shots
    simulator: Simulator

    def write(self) -> None:
        """Diagnose, and write the verdict."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # numerical warnings would hide the progress
            verdict = diagnose(self.shots, self.simulator)
        write_text(self.file, verdict.to_json())

    def read(self) -> Verdict:
        """Return the verdict that was written.

        Raises:
            InputError: the file is broken.
        """
        try:
            return Verdict.load(self.file)
        except VerdictError:
            raise InputError(self.file, "is no verdict; remove it and run again") from None


def verdicts(diagnoses: Sequence[Diagnosis], description: str) -> list[Verdict]:
    """Return the verdicts on all diagnoses; arguments and errors as of ``json_results``."""
    make_missing({diagnosis.file: diagnosis.write for diagnosis in diagnoses}, description)
    return [diagnosis.read() for diagnosis in diagnoses]
