"""Checkpoints and timings of a stage, kept in the repository also for temporary copies.

DVC runs ``dvc exp run --temp`` and queued experiments in a temporary copy, which it removes when
they end.
"""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from filelock import FileLock
from pydantic import FiniteFloat

from rallygap.pipeline.io.artifacts import read_as, write_json
from rallygap.pipeline.runtime.paths import repository_root
from rallygap.pipeline.runtime.provenance import provenance, short

COPIES = "copies"  # folder of scratch/ with checkpoints of temporary copies

Timings = dict[str, FiniteFloat | dict[str, FiniteFloat]]


@contextmanager
def scratch_kept(stage: str, fingerprint: str) -> Iterator[None]:
    """Let a stage in a temporary copy continue where a killed one in another copy stopped.

    Its scratch folder becomes a link into the repository. It is removed when the stage
    succeeds, and no other: another copy may run the same stage with other parameters. Where it
    runs the same stage with the same parameters, this one waits for its end.
    """
    here, home = Path.cwd(), repository_root()
    if here.resolve() == home.resolve():
        yield
        return
    name = short(fingerprint)
    kept, link = home / "scratch" / COPIES / stage / name, here / "scratch" / stage / name
    kept.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(kept.with_name(f"{name}.lock")):
        kept.mkdir(exist_ok=True)
        link.parent.mkdir(parents=True, exist_ok=True)
        if not link.is_symlink():
            link.symlink_to(kept, target_is_directory=True)
        yield
        shutil.rmtree(kept, ignore_errors=True)


def keep_timings(stage: str, fingerprint: str, timings: dict[str, Any]) -> None:
    """Write the timings of a run, if there are any."""
    if timings:
        write_json(_timings_file(repository_root(), stage, fingerprint), timings)


def kept_timings(root: Path, stage: str) -> Timings:
    """The timings of a stage with its present inputs; empty where it ran on another machine.

    Returns:
        Name to seconds, or to seconds by name.

    Raises:
        InputError: an input of the stage is missing, or the file with the timings is broken.
    """
    path = _timings_file(root, stage, provenance(root, stage).fingerprint)
    return read_as(path, Timings, stage) if path.exists() else {}


def _timings_file(root: Path, stage: str, fingerprint: str) -> Path:
    return root / "timings" / stage / f"{short(fingerprint)}.json"
