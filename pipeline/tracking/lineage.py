"""From a file under reports/ or artifacts/ back to the run that wrote it."""

import os
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rallygap.pipeline.io.report_manifest import read_contents
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.tracking.dvc_stages import dvc_stages
from rallygap.pipeline.tracking.recording import EXPERIMENT, store_uri, without_secrets

EXPERIMENT_TAG = "dvc.experiment"


@dataclass(frozen=True)
class Origin:
    """The run of a stage that wrote a file.

    Attributes:
        stage: its name.
        fingerprint: see ``Provenance``.
        run: the id in MLflow.
        status: of the run in MLflow.
        address: of its page in MLflow.
        commit: that was checked out; the changes of an experiment are not in it.
        experiment: name of the DVC experiment, if any.
    """

    stage: str
    fingerprint: str
    run: str
    status: str
    address: str
    commit: str | None
    experiment: str | None


def origin_of(root: Path, path: Path) -> Origin:
    """Find the run that wrote a file or folder.

    Args:
        root: the repository.
        path: an output of a stage, or its like in a kept experiment's folder under reports.

    Raises:
        InputError: no stage writes it, its report is missing or broken, or MLflow cannot be asked
            or knows no such run.
    """
    stage, reports = report_of(root, path)
    fingerprint = read_contents(reports, stage).fingerprint
    store = os.environ.get("MLFLOW_TRACKING_URI") or _local_store(root)
    run = _newest_run(store, fingerprint)
    if run is None:
        problem = f"has the fingerprint {fingerprint}; was it made elsewhere?"
        raise InputError(path, f"no run in {without_secrets(store)} {problem}")
    served = without_secrets(store) if store.startswith("http") else "http://127.0.0.1:5000"
    tags, info = run.data.tags, run.info
    return Origin(
        stage,
        tags["rallygap.fingerprint"],
        info.run_id,
        info.status,
        f"{experiment_page(served, info.experiment_id)}/{info.run_id}",
        tags.get("mlflow.source.git.commit"),
        tags.get(EXPERIMENT_TAG),
    )


def experiment_page(server: str, experiment: str) -> str:
    """The address of the list of runs of an MLflow experiment."""
    return f"{server.rstrip('/')}/#/experiments/{experiment}/runs"


def runs_page(root: Path, server: str) -> str:
    """The address of the list of a repository's runs, or of the first page where there are none."""
    query = "SELECT experiment_id FROM experiments WHERE name = ?"
    try:
        with closing(sqlite3.connect(f"file:{root / 'mlflow.db'}?mode=ro", uri=True)) as store:
            row = store.execute(query, (EXPERIMENT,)).fetchone()
    except sqlite3.Error:
        row = None
    return experiment_page(server, row[0]) if row else server


def report_of(root: Path, path: Path) -> tuple[str, Path]:
    """Find the stage that writes a file, and the folder that the stage's report is in.

    Args:
        root: the repository.
        path: as in ``origin_of``.

    Raises:
        InputError: it is not in the repository, no stage writes it, or dvc.yaml is broken.
    """
    try:
        inside = path.resolve().relative_to(root.resolve())
    except ValueError:
        raise InputError(path, f"is not in the repository {root}") from None
    reports = root / "reports"
    if len(inside.parts) > 2 and (root / Path(*inside.parts[:2]) / "run.json").is_file():
        reports = root / Path(*inside.parts[:2])  # of an experiment that was kept
        inside = Path("reports", *inside.parts[2:])
    for name, stage in dvc_stages(root / "dvc.yaml").items():
        if {inside, *inside.parents} & {*stage.outs}:
            return name, reports
    raise InputError(path, "no stage of dvc.yaml writes it; give a file under reports or artifacts")


def _local_store(root: Path) -> str:
    """The repository's store, which MLflow would make where there is none."""
    if not (root / "mlflow.db").is_file():
        problem = "is missing, because no stage has run here; whoever ran it has the run"
        raise InputError(root / "mlflow.db", problem)
    return store_uri(root)


def _newest_run(store: str, fingerprint: str) -> Any:
    """The newest run of a fingerprint; those that ended well first."""
    from mlflow import MlflowClient
    from mlflow.exceptions import MlflowException
    from sqlalchemy.exc import SQLAlchemyError

    sought = f"tags.`rallygap.fingerprint` LIKE '{fingerprint}%'"
    try:
        client = MlflowClient(store)
        experiments = [one.experiment_id for one in client.search_experiments()]
        runs = client.search_runs(experiments, sought, order_by=["start_time DESC"])
    except (MlflowException, SQLAlchemyError, ImportError) as error:
        reason = without_secrets(" ".join(str(error).split()))
        raise InputError(without_secrets(store), f"cannot be asked: {reason[:200]}") from None
    return next((run for run in runs if run.info.status == "FINISHED"), next(iter(runs), None))
