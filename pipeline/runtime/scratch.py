"""What a stage leaves beside its outputs, kept in the repository wherever the stage ran.

DVC runs ``dvc exp run --temp`` and queued experiments in a temporary copy, which it removes when
they end, well or badly.
"""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from filelock import FileLock
from pydantic import FiniteFloat

from pipeline.io.artifacts import read_as, write_json
from pipeline.io.report_manifest import read_contents
from pipeline.runtime.paths import repository_root
from pipeline.runtime.provenance import short

COPIES = "copies"  # folder of scratch/ for what killed stages left in temporary copies

Timings = dict[str, FiniteFloat | dict[str, FiniteFloat]]


@contextmanager
def scratch_kept(stage: str, fingerprint: str) -> Iterator[None]:
    """Let a stage in a temporary copy go on where a killed one in another copy stopped.

    Its scratch folder becomes a link into the repository. What is kept there goes when the stage
    succeeds, and nothing else: another copy may be at the same stage with other parameters. Where
    it is at the same stage with the same ones, this one waits until it has ended.
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
    """Write down how long things took in a run, where there is anything to say."""
    if timings:
        write_json(_timings_file(repository_root(), stage, fingerprint), timings)


def kept_timings(root: Path, report: Path) -> Timings:
    """How long things took when a stage left this report.

    Empty where that was on another machine, or never.

    Args:
        root: of the repository.
        report: the stage's folder, among the present reports or those of an experiment.

    Returns:
        Name to seconds, or to seconds by name, as the stage noted them.

    Raises:
        InputError: the report's contents.json or the file with the timings is broken.
    """
    if not (report / "contents.json").exists():
        return {}
    fingerprint = read_contents(report.parent, report.name).fingerprint
    path = _timings_file(root, report.name, fingerprint)
    return read_as(path, Timings, report.name) if path.exists() else {}


def _timings_file(root: Path, stage: str, fingerprint: str) -> Path:
    return root / "timings" / stage / f"{short(fingerprint)}.json"
