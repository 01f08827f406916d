"""A run in MLflow around a block of work: a stage of the pipeline, or a trial of a sweep.

The store is the repository's ``mlflow.db`` or the one that MLFLOW_TRACKING_URI names. Whatever goes
wrong with it costs one line of warning, and the stage continues. A stage that is killed leaves its
run open; the next one that is recorded in the same store closes it.
"""

import os
import re
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import psutil
from filelock import FileLock

from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.git import git_commit
from rallygap.pipeline.runtime.guard import guarded
from rallygap.pipeline.runtime.paths import repository_root
from rallygap.pipeline.runtime.provenance import Provenance
from rallygap.pipeline.runtime.scratch import keep_timings, scratch_kept
from rallygap.pipeline.tracking.results import Results
from rallygap.pipeline.tracking.values import changed_params, dotted, flat_metrics, reported_metrics

Value = TypeVar("Value")

EXPERIMENT = "rallygap"  # of MLflow, with all runs
GROUP_TAG, PROCESS_TAG, HOST_TAG = "rallygap.group", "rallygap.process", "rallygap.host"
LONGEST_REASON = 300  # characters of what MLflow says when it fails
STORE_MADE = 60.0  # s, that another process may take to make the store


@dataclass(frozen=True)
class ParentRun:
    """The run above others: of a reproduction, of a DVC experiment, or of a sweep.

    Attributes:
        key: runs with the same key share the parent.
        name: of the run.
        tags: of MLflow.
        params: by dotted key.
        gathers_metrics: of all stages in the working directory, those that DVC skips, too.
    """

    key: str
    name: str
    tags: dict[str, str]
    params: dict[str, str] = field(default_factory=dict)
    gathers_metrics: bool = False


@dataclass(frozen=True)
class RunStart:
    """What is known of a run when it starts: name, nested parameters, tags and the run above it."""

    name: str
    params: dict[str, Any]
    tags: dict[str, str]
    parent: ParentRun | None = None


@contextmanager
def tracked_stage(
    stage: str, origin: Provenance, params: dict[str, Any], results: Callable[[], Results]
) -> Iterator[None]:
    """Guard and record the stage of this block, and keep its scratch folder and its timings.

    ``results`` is called when the stage has ended, well or badly.
    """
    with guarded(stage), tracked_run(stage_start(stage, origin, params), results):
        with scratch_kept(stage, origin.fingerprint):
            yield
        keep_timings(stage, origin.fingerprint, results().metrics.get("timings", {}))


@contextmanager
def tracked_run(start: RunStart, results: Callable[[], Results]) -> Iterator[None]:
    """Record what is done in this block, and how it ends; ``results`` is called when it has."""
    parent = attempt(start.name, lambda: _open(start))
    status = "FAILED"
    try:
        yield
        status = "FINISHED"
    except (KeyboardInterrupt, SystemExit):
        status = "KILLED"
        raise
    finally:
        if parent is not None:
            attempt(start.name, lambda: _close(start, parent, status, results()))


def attempt(name: str, action: Callable[[], Value]) -> Value | None:
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
    shared = {
        "dvc.experiment": os.environ.get("DVC_EXP_NAME"),
        "dvc.baseline": os.environ.get("DVC_EXP_BASELINE_REV"),
        "mlflow.source.git.commit": git_commit(home),
    }
    known = {name: value for name, value in shared.items() if value}
    own = {"dvc.stage": stage, "rallygap.fingerprint": origin.fingerprint}
    tags = {**known, **own, "mlflow.source.name": origin.command}
    key = reproduction()
    if key is None:
        return RunStart(stage, params, tags)
    name = known.get("dvc.experiment", "reproduction")
    above = {**known, "mlflow.source.name": "dvc"}
    parent = ParentRun(key, name, above, changed_params(home), gathers_metrics=True)
    return RunStart(stage, params, tags, parent)


def reproduction() -> str | None:
    """The DVC process above this one, which makes its stages one reproduction.

    Returns:
        Its key; None for a stage that was started by hand.
    """
    for process in psutil.Process().parents():
        words = process.as_dict(["cmdline"])["cmdline"] or []  # None where it is not allowed
        if any(Path(word).stem == "dvc" for word in words[:3]):
            return _process_name(process)
    return None


def store_uri(home: Path) -> str:
    """The MLflow store of the repository at ``home``."""
    return f"sqlite:///{home / 'mlflow.db'}"


def without_secrets(text: str) -> str:
    """Return text without the names and passwords in its URLs."""
    text = re.sub(r"(://)[^\s'\"]*@", r"\1***@", text)
    return re.sub(r"(?i)((?:password|passwd|token|secret|key)=)[^&\s'\"]+", r"\1***", text)


def _open(start: RunStart) -> str:
    """Start the run; return the id of the run above it, empty where there is none."""
    import mlflow

    home, named = repository_root(), os.environ.get("MLFLOW_TRACKING_URI")
    # MLflow cannot make the tables of one store, or one parent, from two processes at once.
    with FileLock(home / "mlflow.db.lock", timeout=STORE_MADE):
        _connect(home, named)
        if mlflow.get_experiment_by_name(EXPERIMENT) is None:
            folder = None if named else (home / "mlartifacts").as_uri()
            mlflow.create_experiment(EXPERIMENT, artifact_location=folder)
        mlflow.set_experiment(EXPERIMENT)
        _close_abandoned()
        parent = _parent_id(start.parent) if start.parent else ""
    process = {PROCESS_TAG: this_process(), HOST_TAG: socket.gethostname()}
    mlflow.start_run(
        run_name=start.name,
        parent_run_id=parent or None,
        tags={**start.tags, **process},
        log_system_metrics=True,
    )
    try:
        mlflow.log_params(dotted(start.params))
    except Exception:
        mlflow.end_run("FAILED")
        raise
    return parent


def _connect(home: Path, named: str | None) -> None:
    """Use the store that is named, or the repository's, which is made if there is none."""
    import mlflow
    from sqlalchemy import create_engine

    path = home / "mlflow.db"
    if named is None and not path.exists():
        # Whole or not at all: MLflow could not open half of one.
        unfinished = path.with_name(f"{path.name}.new")
        unfinished.unlink(missing_ok=True)
        mlflow.set_tracking_uri(f"sqlite:///{unfinished}")
        mlflow.search_experiments(max_results=1)
        unfinished.replace(path)
    uri = named or store_uri(home)
    if not uri.startswith("http"):  # a database is tried first: MLflow would try for minutes
        with create_engine(uri).connect() as connection:
            connection.exec_driver_sql("SELECT 1")
    mlflow.set_tracking_uri(uri)


def _close_abandoned() -> None:
    """Mark as killed the open runs whose process on this machine has died, and their parents."""
    import mlflow

    here = f"attributes.status = 'RUNNING' AND tags.`{HOST_TAG}` = '{socket.gethostname()}'"
    for run in mlflow.search_runs(filter_string=here, output_format="list"):
        if not process_lives(run.data.tags[PROCESS_TAG]):
            _end(run.info.run_id, "KILLED")
            if parent := run.data.tags.get("mlflow.parentRunId"):
                _end(parent, "KILLED")


def _process_name(process: psutil.Process) -> str:
    # psutil's hash is of the number and the time since the machine started, which no clock that is
    # set shifts, as it would the time of day.
    return f"{process.pid}-{hash(process)}"


def this_process() -> str:
    """A name of this process that no later one has."""
    return _process_name(psutil.Process())


def process_lives(name: str) -> bool:
    """Whether a process of this machine is still there, by its name of ``this_process``."""
    try:
        return _process_name(psutil.Process(int(name.partition("-")[0]))) == name
    except psutil.NoSuchProcess:
        return False


def _parent_id(parent: ParentRun) -> str:
    """The id of the parent: created by the first run below it, found by the others."""
    import mlflow

    query = f"tags.`{GROUP_TAG}` = '{parent.key}'"
    for run in mlflow.search_runs(filter_string=query, max_results=1, output_format="list"):
        return str(run.info.run_id)
    tags = {**parent.tags, GROUP_TAG: parent.key}
    with mlflow.start_run(run_name=parent.name, tags=tags) as run:
        mlflow.log_params(parent.params)
    return str(run.info.run_id)


def _close(start: RunStart, parent: str, status: str, results: Results) -> None:
    """Log what the run leaves and end it; its parent gets its status, and metrics it gathers."""
    import mlflow
    from mlflow.data import sources
    from mlflow.data.meta_dataset import MetaDataset

    try:
        for step, metrics in flat_metrics(results.metrics).items():
            mlflow.log_metrics(metrics, step=step)
        for data in results.inputs:  # `mlflow.data.get_source` finds the file again
            source = sources.LocalArtifactDatasetSource(data.source)  # type: ignore[attr-defined]
            dataset = MetaDataset(source, data.name, data.digest)  # type: ignore[abstract]
            mlflow.log_input(dataset, tags={"rows": str(data.rows)})
        for figure in results.figures:
            mlflow.log_artifact(str(figure), "figures")
        if status == "FINISHED" and results.models:
            from rallygap.pipeline.tracking.model_registry import register_model

            for model in results.models:
                register_model(model)
    finally:
        mlflow.end_run(status)
    if parent:
        gathered = start.parent is not None and start.parent.gathers_metrics
        _end(parent, status, reported_metrics() if gathered else {})


def _end(run_id: str, status: str, metrics: dict[str, float] | None = None) -> None:
    """Take up a run again, to log its last metrics and end it with a status."""
    import mlflow

    mlflow.start_run(run_id=run_id)
    try:
        mlflow.log_metrics(metrics or {})
    finally:
        mlflow.end_run(status)
