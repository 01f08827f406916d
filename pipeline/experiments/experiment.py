"""The frame of experiments that take hours: what they resume from, and what they publish.

What they compute stays in a folder that belongs to the code, the settings and the artefacts that it
depends on. A killed run resumes there, unless one of them has changed. Reports replace former ones
together, at the end.
"""

import hashlib
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from filelock import FileLock, Timeout
from matplotlib.figure import Figure

from rallygap.pipeline.evaluation.costs import machine
from rallygap.pipeline.experiments.stale import check_committed, code_of
from rallygap.pipeline.io.artifacts import replacing_files, write_csv, write_json
from rallygap.pipeline.io.figure_style import apply_style, save_figure
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import combined_hash, short

PARAMS = "params.yaml"
SCRATCH = Path("scratch")


@dataclass(frozen=True)
class Run:
    """A run of an experiment.

    Attributes:
        root: of the repository.
        scratch: folder of what a killed run leaves to the next one; the end of the run removes it.
        origin: the machine, and the commit and the fingerprint at the start.
    """

    root: Path
    scratch: Path
    origin: dict[str, Any]

    def publish(
        self,
        folder: str,
        tables: Mapping[str, pd.DataFrame],
        figures: Mapping[str, Figure],
        record: str,
        sample: Mapping[str, Any],
        digits: int = 4,
    ) -> None:
        """Replace reports by those of this run, all at once.

        Args:
            folder: below ``reports``.
            tables: by the names of their files, without the ending.
            figures: likewise.
            record: name of the file that says where the reports come from.
            sample: what it says of seeds and of numbers of resamples, trainings and the like.
            digits: significant ones of the numbers in tables.

        Raises:
            InputError: ``reports`` cannot be written to.
        """
        with replacing_files(self.root / "reports") as reports:
            out = reports / folder
            for name, table in tables.items():
                write_csv(out / f"{name}.csv", table, digits)
            for name, figure in figures.items():
                save_figure(out / f"{name}.png", figure)
            write_json(out / f"{record}.json", {**self.origin, **sample})


@contextmanager
def running(root: Path, name: str, inputs: Sequence[str] = (), data: str = "") -> Iterator[Run]:
    """Run an experiment within this block; figures have the style of all.

    Args:
        root: of the repository.
        name: of its module below ``pipeline``. Results depend on all that this module imports.
        inputs: files and folders that it reads, besides params.yaml.
        data: digest of what it reads from outside of the repository.

    Raises:
        InputError: code is not committed, an input is missing, or the experiment runs already.
    """
    check_committed(root)
    fingerprint = _fingerprint(root, name, inputs, data)
    origin = machine(root) | {"fingerprint": fingerprint}
    folder = root / SCRATCH / name.removesuffix(".run")
    scratch = folder / short(fingerprint)
    apply_style()
    with _alone(folder):
        yield Run(root, scratch, origin)
        # A worker of a killed run may still write here.
        shutil.rmtree(scratch, ignore_errors=True)


def _fingerprint(root: Path, name: str, inputs: Sequence[str], data: str) -> str:
    code = [one for one in code_of([f"rallygap.pipeline.{name}"], ()) if (root / one).exists()]
    content = combined_hash(root, [*code, PARAMS, *inputs])
    return hashlib.sha256(f"{content} {data}".encode()).hexdigest()


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Refuse a second run, which would remove files of the first and mix their reports."""
    try:
        lock = FileLock(folder.with_name(f"{folder.name}.lock")).acquire(timeout=0)
    except Timeout:
        raise InputError(folder.name, "is running already; wait until it has ended") from None
    with lock:
        yield
