"""Runs in MLflow: opened when a stage starts, closed with what it leaves.

The store is the repository's ``mlflow.db`` or the one that MLFLOW_TRACKING_URI names. Stages that
run at the same time share it.
"""

import json
import logging
import os
import socket
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# Read when mlflow is imported. Telemetry stays off; the rest is the user's, if set.
os.environ["MLFLOW_DISABLE_TELEMETRY"] = "true"
os.environ["DO_NOT_TRACK"] = "true"
os.environ.setdefault("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "1")
os.environ.setdefault("MLFLOW_HTTP_REQUEST_TIMEOUT", "5")
os.environ.setdefault("MLFLOW_LOGGING_LEVEL", "ERROR")

import mlflow
import mlflow.store.db.utils
import psutil
from filelock import FileLock
from mlflow import MlflowClient
from mlflow.entities import Dataset, DatasetInput, Param, Run
from mlflow.system_metrics.system_metrics_monitor import SystemMetricsMonitor

from rallygap.pipeline.io.markdown import markdown_table
from rallygap.pipeline.runtime.paths import repository_root
from rallygap.pipeline.tracking.changed_params import dotted
from rallygap.pipeline.tracking.headlines import headline_metrics, metric_points, upstream_headlines
from rallygap.pipeline.tracking.recording import (
    EXPERIMENT,
    InputData,
    ParentRun,
    Results,
    RunStart,
    store_uri,
)

STAGE_OF_PREDICTORS = "train_predictor"
KEY_TAG, PROCESS_TAG = "rallygap.reproduction", "rallygap.process"
STORE_BUSY = 5.0  # s, that another process may hold the repository's store
STORE_MADE = 60.0  # s, that another process may take to make it

# MLflow retries to reach a database for 100 s, and has no setting for that.
mlflow.store.db.utils.MAX_RETRY_COUNT = 2
logging.getLogger("urllib3.connectionpool").setLevel(logging.ERROR)  # it warns of every retry


@dataclass(frozen=True)
class OpenRun:
    """A run that is at work, the run above it, and the monitor of the machine."""

    client: MlflowClient
    start: RunStart
    run_id: str
    parent_id: str | None
    monitor: Any

    def end(self, status: str, results: Results) -> None:
        """Log what the run leaves and close it with a status in MLflow's words."""
        self.monitor.finish()
        self.client.log_batch(self.run_id, metrics=list(metric_points(results.metrics)))
        if results.inputs:
            self.client.log_inputs(self.run_id, [_data_set(one) for one in results.inputs])
        for figure in results.figures:
            self.client.log_artifact(self.run_id, str(figure), "figures")
        if self.start.name == STAGE_OF_PREDICTORS and status == "FINISHED":
            from rallygap.pipeline.tracking.model_registry import (
                register_predictors,  # takes seconds
            )

            register_predictors(self.client, self.run_id, results)
        self.client.set_terminated(self.run_id, status)
        if self.start.parent is not None and self.parent_id is not None:
            self._end_parent(self.start.parent, self.parent_id, status, results)

    def _end_parent(self, parent: ParentRun, run_id: str, status: str, results: Results) -> None:
        """Give the parent the headline metrics, and move its end to this run's."""
        headlines = headline_metrics(self.start.name, results.metrics)
        if Path("dvc.yaml").exists():
            headlines += upstream_headlines(self.start.name)
        self.client.log_batch(run_id, metrics=headlines)
        earlier = self.client.get_run(run_id).info.status
        failed = parent.failure_is_final and earlier in ("FAILED", "KILLED")
        self.client.set_terminated(run_id, earlier if failed else status)


def open_run(start: RunStart) -> OpenRun:
    """Open a run, below its parent where it has one."""
    home, named = repository_root(), os.environ.get("MLFLOW_TRACKING_URI")
    store = named or store_uri(home)
    mlflow.set_tracking_uri(store)  # for the registry and the monitor
    # MLflow cannot make the tables of one store, or one parent, from two processes at once.
    with FileLock(home / "mlflow.db.lock", timeout=STORE_MADE):
        if named is None:
            _prepare_store(home / "mlflow.db")
        client = MlflowClient(store)
        experiment = _experiment_id(client, None if named else (home / "mlartifacts").as_uri())
        mlflow.set_experiment(experiment_id=experiment)  # of the predictors that are logged
        _close_abandoned(client, experiment)
        parent_id = _parent_run(client, experiment, start.parent) if start.parent else None
    process = psutil.Process()
    tags = {**start.tags, PROCESS_TAG: f"{process.pid}-{process.create_time():.0f}"}
    tags |= {"rallygap.host": socket.gethostname()}
    if parent_id:
        tags["mlflow.parentRunId"] = parent_id
    run_id = client.create_run(experiment, tags=tags, run_name=start.name).info.run_id
    client.log_batch(run_id, params=_params(dotted(start.params)))
    monitor: Any = SystemMetricsMonitor(run_id)  # type: ignore[no-untyped-call]
    monitor.start()
    return OpenRun(client, start, run_id, parent_id, monitor)


def _data_set(data: InputData) -> DatasetInput:
    """An input data set as MLflow shows it; ``mlflow.data.get_source`` finds the file again."""
    source, profile = json.dumps({"uri": data.source}), json.dumps({"num_rows": data.rows})
    return DatasetInput(Dataset(data.name, data.digest, "local", source, profile=profile))


def _params(values: dict[str, str]) -> list[Param]:
    return [Param(key, value) for key, value in values.items()]


def _prepare_store(path: Path) -> None:
    """Make the repository's store where it is missing, and see that it can be written to.

    It appears whole or not at all: MLflow could never open one that a kill left half-made.

    Raises:
        sqlite3.OperationalError: another process holds the store, or it cannot be opened.
    """
    if not path.exists():
        unfinished = path.with_name(f"{path.name}.new")
        unfinished.unlink(missing_ok=True)
        MlflowClient(f"sqlite:///{unfinished}").search_experiments()
        unfinished.replace(path)
    with closing(sqlite3.connect(path, STORE_BUSY, isolation_level=None)) as connection:
        connection.execute("BEGIN IMMEDIATE")


def _experiment_id(client: MlflowClient, artifacts: str | None) -> str:
    """The MLflow experiment of this project, created where it is missing."""
    experiment = client.get_experiment_by_name(EXPERIMENT)
    if experiment is None:
        return client.create_experiment(EXPERIMENT, artifact_location=artifacts)
    return str(experiment.experiment_id)


def _close_abandoned(client: MlflowClient, experiment: str) -> None:
    """Mark as killed the open runs whose process on this machine has died, and their parents."""
    here = f"tags.`rallygap.host` = '{socket.gethostname()}'"
    for run in client.search_runs([experiment], f"attributes.status = 'RUNNING' AND {here}"):
        if not _lives(run.data.tags[PROCESS_TAG]):
            client.set_terminated(run.info.run_id, "KILLED")
            if parent := run.data.tags.get("mlflow.parentRunId"):
                client.set_terminated(parent, "KILLED")


def _lives(process: str) -> bool:
    number, created = process.split("-")
    try:
        return f"{psutil.Process(int(number)).create_time():.0f}" == created
    except psutil.NoSuchProcess:
        return False


def _parent_run(client: MlflowClient, experiment: str, parent: ParentRun) -> str:
    """The id of the parent: created by the first run below it, found by the others."""
    runs = client.search_runs([experiment], f"tags.`{KEY_TAG}` = '{parent.key}'", max_results=1)
    run = runs[0] if runs else _created_parent(client, experiment, parent)
    return str(run.info.run_id)


def _created_parent(client: MlflowClient, experiment: str, parent: ParentRun) -> Run:
    tags = {**parent.tags, KEY_TAG: parent.key, "mlflow.source.name": parent.source}
    if parent.changed:  # as a table, which the page of the run shows
        rows = [(key, *change) for key, change in parent.changed.items()]
        tags["mlflow.note.content"] = markdown_table(["parameter", "committed", "here"], rows)
    run = client.create_run(experiment, tags=tags, run_name=parent.name)
    changed = {key: change.here for key, change in parent.changed.items()}
    client.log_batch(run.info.run_id, params=_params(changed))
    return run
