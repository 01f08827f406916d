"""A run in MLflow around a block of work: a stage of the pipeline, or a trial of a sweep.

MLflow works in the process of the stage, with short timeouts. Whatever goes wrong with it costs one
line of warning, and the stage continues. A stage that is killed leaves its run open; the next one
that is recorded in the same store closes it (``mlflow_run._close_abandoned``).
"""

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import psutil

from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.git import git_commit
from rallygap.pipeline.runtime.guard import guarded
from rallygap.pipeline.runtime.paths import repository_root
from rallygap.pipeline.runtime.provenance import Provenance
from rallygap.pipeline.runtime.scratch import keep_timings, scratch_kept
from rallygap.pipeline.tracking.changed_params import Change, changed_params

Value = TypeVar("Value")

EXPERIMENT = "rallygap"  # of MLflow, with all runs
LONGEST_REASON = 300  # characters of what MLflow says when it fails


@dataclass(frozen=True)
class InputData:
    """A data set that a stage read.

    Attributes:
        name: of the data set.
        source: path of its file or folder.
        rows: or other items in it.
        digest: MD5 of its content.
    """

    name: str
    source: str
    rows: int
    digest: str


@dataclass(frozen=True)
class Results:
    """What a run leaves: nested metrics, the data sets it read, paths of its figures."""

    metrics: dict[str, Any] = field(default_factory=dict)
    inputs: list[InputData] = field(default_factory=list)
    figures: list[Path] = field(default_factory=list)


@dataclass(frozen=True)
class ParentRun:
    """The run above others: of a reproduction, of a DVC experiment, or of a sweep.

    Attributes:
        key: runs with the same key share the parent.
        name: of the run.
        source: the command that makes it.
        tags: of MLflow.
        changed: parameters that differ from the commit, by dotted key.
        failure_is_final: whether one failed run below it makes it fail.
    """

    key: str
    name: str
    source: str
    tags: dict[str, str] = field(default_factory=dict)
    changed: dict[str, Change] = field(default_factory=dict)
    failure_is_final: bool = True


@dataclass(frozen=True)
class RunStart:
    """What is known of a run when it starts: name, nested parameters, tags and the run above it."""

    name: str
    params: dict[str, Any]
    tags: dict[str, str]
    parent: ParentRun | None = None


@contextmanager
def recorded(
    stage: str, origin: Provenance, params: dict[str, Any], results: Callable[[], Results]
) -> Iterator[None]:
    """Guard and record the stage of this block, and keep its scratch folder and its timings.

    Args:
        stage: its name.
        origin: its command and fingerprint.
        params: its parameters.
        results: called when the stage has ended, well or badly.
    """
    with guarded(stage), recording(stage_start(stage, origin, params), results):
        with scratch_kept(stage, origin.fingerprint):
            yield
        keep_timings(stage, origin.fingerprint, results().metrics.get("timings", {}))


@contextmanager
def recording(start: RunStart, results: Callable[[], Results]) -> Iterator[None]:
    """Record what is done in this block, and how it ends.

    Args:
        start: what is known of the run.
        results: called when the block has ended, well or badly.
    """
    from rallygap.pipeline.tracking.mlflow_run import open_run  # takes seconds

    run = _attempt(start.name, lambda: open_run(start))
    status = "FAILED"
    try:
        yield
        status = "FINISHED"
    except (KeyboardInterrupt, SystemExit):
        status = "KILLED"
        raise
    finally:
        if run is not None:
            _attempt(start.name, lambda: run.end(status, results()))


def _attempt(name: str, action: Callable[[], Value]) -> Value | None:
    """Do something with MLflow; None, and a warning, where it fails in whatever way."""
    try:
        return action()
    except Exception as error:
        reason = without_secrets(" ".join(str(error).split()))[:LONGEST_REASON]
        warn(f"MLflow has no complete record of {name}: {type(error).__name__}: {reason}")
        return None


def stage_start(stage: str, origin: Provenance, params: dict[str, Any]) -> RunStart:
    """Describe a stage that starts in the working directory."""
    home = repository_root()
    changed = changed_params(home)
    shared = {
        "dvc.experiment": os.environ.get("DVC_EXP_NAME"),
        "dvc.baseline": os.environ.get("DVC_EXP_BASELINE_REV"),
        "mlflow.source.git.commit": git_commit(home),
    }
    known = {name: value for name, value in shared.items() if value}
    tags = {
        **known,
        "dvc.stage": stage,
        "rallygap.fingerprint": origin.fingerprint,
        "mlflow.source.name": origin.command,
        **{f"changed.{key}": str(change) for key, change in changed.items()},
    }
    key = reproduction()
    name = known.get("dvc.experiment", "reproduction")
    parent = ParentRun(key, name, "dvc", known, changed) if key else None
    return RunStart(stage, params, tags, parent)


def reproduction() -> str | None:
    """The DVC process above this one, which makes its stages one reproduction.

    Returns:
        Its key; None for a stage that was started by hand.
    """
    for process in psutil.Process().parents():
        known = process.as_dict(["pid", "cmdline", "create_time"])  # None for what is not allowed
        if any(Path(word).stem == "dvc" for word in (known["cmdline"] or [])[:3]):
            return f"{known['pid']}-{known['create_time']:.0f}"
    return None


def store_uri(home: Path) -> str:
    """The MLflow store of the repository at ``home``."""
    return f"sqlite:///{home / 'mlflow.db'}"


def without_secrets(text: str) -> str:
    """Return text without the names and passwords in its URLs."""
    text = re.sub(r"(://)[^\s'\"]*@", r"\1***@", text)
    return re.sub(r"(?i)((?:password|passwd|token|secret|key)=)[^&\s'\"]+", r"\1***", text)
