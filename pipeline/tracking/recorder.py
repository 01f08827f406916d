"""The process that writes one stage into MLflow: ``python -m pipeline.tracking.recorder FOLDER``.

The folder has ``start.json``, and ``end.json`` once the stage has ended. The end of the standard
input says that it has, one way or another: without ``end.json`` it was killed. A store that fails
ends the process with status 1 and the reason as the last line on stderr.
"""

import json
import os
import re
import shutil
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

# Read when mlflow is imported. Telemetry stays off; the rest is the user's, if set.
os.environ["MLFLOW_DISABLE_TELEMETRY"] = "true"
os.environ["DO_NOT_TRACK"] = "true"
os.environ.setdefault("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "1")
os.environ.setdefault("MLFLOW_HTTP_REQUEST_TIMEOUT", "5")

import mlflow
from filelock import FileLock
from mlflow import MlflowClient
from mlflow.entities import Dataset, DatasetInput, Metric, Param
from mlflow.system_metrics.system_metrics_monitor import SystemMetricsMonitor
from pyarrow.parquet import read_schema

from pipeline.tracking.model_registry import STAGE_OF_PREDICTORS, register_predictors
from pipeline.tracking.redaction import without_secrets

EXPERIMENT = "rallygap"
LONGEST_VALUE = 250  # characters of a parameter that every MLflow store takes
PARAMS_A_BATCH = 100
METRICS_A_BATCH = 1000
# From Arrow's names to MLflow's; a column of any other type is shown as text.
COLUMN_TYPES = {"double": "double", "float": "float", "int64": "long", "bool": "boolean"}


def main(messages: Path) -> None:
    """Record the stage that the messages describe."""
    start = json.loads((messages / "start.json").read_text())
    mlflow.set_tracking_uri(start["store"])  # the registry looks up logged models there
    # MLflow cannot make the tables of one store from two processes at once.
    with FileLock(start["lock"]):
        if start["artifacts"]:  # the repository's own store
            make_store(Path(start["store"].removeprefix("sqlite:///")))
        client = MlflowClient(start["store"])
        experiment = experiment_id(client, start["artifacts"])
        parent = parent_run(client, experiment, start)
    child = child_run(client, experiment, parent, start)
    with system_metrics(child):
        end = awaited_end(messages / "end.json")
    log_results(client, child, end)
    client.set_terminated(child, end["status"], end["time"])
    if parent:
        finish_parent(client, parent, start, end)
    if start["stage"] == STAGE_OF_PREDICTORS and end["status"] == "FINISHED":
        register_predictors(client, child, end)


@contextmanager
def system_metrics(run: str) -> Iterator[None]:
    """Log what the machine does meanwhile, every ten seconds: processor, memory, disk, network."""
    monitor: Any = SystemMetricsMonitor(run)  # type: ignore[no-untyped-call]
    monitor.start()
    yield
    monitor.finish()


def make_store(path: Path) -> None:
    """Make the repository's store where it is missing, whole or not at all.

    Half of its tables, as left by a kill, are nothing that MLflow could ever open again.
    """
    if path.exists():
        return
    unfinished = path.with_name(f"{path.name}.new")
    unfinished.unlink(missing_ok=True)
    MlflowClient(f"sqlite:///{unfinished}").search_experiments()
    unfinished.replace(path)


def awaited_end(message: Path) -> dict[str, Any]:
    """Wait until the stage has ended and return how."""
    sys.stdin.read()
    if message.exists():
        return dict(json.loads(message.read_text()))
    return {"status": "KILLED", "time": round(time.time() * 1000)}


def experiment_id(client: MlflowClient, artifacts: str | None) -> str:
    """The MLflow experiment of this project, created where it is missing."""
    experiment = client.get_experiment_by_name(EXPERIMENT)
    if experiment is None:
        return client.create_experiment(EXPERIMENT, artifact_location=artifacts)
    return str(experiment.experiment_id)


def parent_run(client: MlflowClient, experiment: str, start: dict[str, Any]) -> str | None:
    """The run of the reproduction: created by its first stage, found by the others."""
    key = start["reproduction"]
    if key is None:
        return None
    runs = client.search_runs(
        [experiment], f"tags.`rallygap.reproduction` = '{key}'", max_results=1
    )
    if runs:
        return str(runs[0].info.run_id)
    shared = ("dvc.experiment", "dvc.baseline", "mlflow.source.git.commit")
    tags = {name: start["tags"][name] for name in shared if name in start["tags"]}
    sweep = start.get("parent")
    tags |= {"rallygap.reproduction": key, "mlflow.source.name": sweep or "dvc"}
    name = sweep or tags.get("dvc.experiment", "reproduction")
    run = client.create_run(experiment, start["time"], tags, run_name=name)
    return str(run.info.run_id)


def child_run(
    client: MlflowClient, experiment: str, parent: str | None, start: dict[str, Any]
) -> str:
    """The run of the stage, with its parameters."""
    tags = start["tags"] | ({"mlflow.parentRunId": parent} if parent else {})
    run = client.create_run(experiment, start["time"], tags, run_name=start["stage"])
    params = [Param(".".join(keys), shortened(value)) for keys, value in flat(start["params"])]
    for batch in batches(params, PARAMS_A_BATCH):
        client.log_batch(run.info.run_id, params=batch)
    return str(run.info.run_id)


def log_results(client: MlflowClient, run: str, end: dict[str, Any]) -> None:
    """Log what the stage left: metrics, input data sets, figures."""
    metrics = list(metric_points(end.get("metrics", {}), end["time"]))
    for batch in batches(metrics, METRICS_A_BATCH):
        client.log_batch(run, metrics=batch)
    inputs = [data_set(**item) for item in end.get("inputs", [])]
    if inputs:
        client.log_inputs(run, inputs)
    for figure in end.get("figures", []):
        client.log_artifact(run, figure, "figures")


def finish_parent(
    client: MlflowClient, parent: str, start: dict[str, Any], end: dict[str, Any]
) -> None:
    """Move the reproduction's end to this stage's; one failed stage makes it fail.

    A sweep goes on where a trial fails, so there the last one tells.
    """
    earlier = client.get_run(parent).info.status
    failed = earlier in ("FAILED", "KILLED") and "parent" not in start
    status = earlier if failed else end["status"]
    client.set_terminated(parent, status, end["time"])


def flat(values: dict[str, Any], *above: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """The leaves of a nested dictionary, each with the keys that lead to it."""
    for key, value in values.items():
        # MLflow allows few characters in a name.
        keys = (*above, re.sub(r"[^\w.: -]", "_", str(key)))
        if isinstance(value, dict):
            yield from flat(value, *keys)
        else:
            yield keys, value


def shortened(value: Any) -> str:
    """A parameter as text, cut where a store would cut or refuse it."""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 1] + "…"


def metric_points(metrics: dict[str, Any], timestamp: int) -> Iterator[Metric]:
    """The numbers among nested metrics; a level of whole numbers becomes MLflow's step.

    So ``{"position": {"100": {"mean": 3.0}}}`` is ``position/mean`` at step 100, and MLflow draws
    the error over the horizon.
    """
    for keys, value in flat(metrics):
        if isinstance(value, int | float):
            steps = [int(key) for key in keys if key.isdecimal()]
            name = "/".join(key for key in keys if not key.isdecimal())
            yield Metric(name, value, timestamp, steps[-1] if steps else 0)


def data_set(name: str, source: str, digest: str, rows: int) -> DatasetInput:
    """An input data set as MLflow shows it; ``mlflow.data.get_source`` finds the file again."""
    profile = json.dumps({"num_rows": rows})
    uri = json.dumps({"uri": source})
    return DatasetInput(Dataset(name, digest, "local", uri, columns(Path(source)), profile))


def columns(table: Path) -> str | None:
    """The columns of a parquet file in MLflow's words; None for what is no table."""
    if table.suffix != ".parquet" or not table.is_file():
        return None
    described = [
        {"type": COLUMN_TYPES.get(str(one.type), "string"), "name": one.name}
        for one in read_schema(table)
    ]
    return json.dumps({"mlflow_colspec": described})


def batches(items: Sequence[Any], size: int) -> Iterator[Sequence[Any]]:
    """Cut a sequence into pieces that a store takes in one call."""
    return (items[first : first + size] for first in range(0, len(items), size))


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    try:
        main(folder)
    except Exception as error:
        reason = without_secrets(" ".join(str(error).split()))
        sys.exit(f"{type(error).__name__}: {reason[:300]}")
    finally:
        sys.stdin.read()  # the stage may still have something to say
        shutil.rmtree(folder)
