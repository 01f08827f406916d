"""Stages are recorded in MLflow, and a store that fails costs them one warning."""

import os
import re
import shutil
import signal
import socket
import sqlite3
from contextlib import closing
from pathlib import Path
from unittest.mock import Mock

import mlflow
import pytest

from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.predictors.trainer import train
from rallygap.pipeline.runtime.provenance import Provenance
from rallygap.pipeline.tracking import runs as tracking
from rallygap.pipeline.tracking.live import LiveRun, live_run
from rallygap.pipeline.tracking.results import InputData, Results
from rallygap.pipeline.tracking.runs import tracked_stage
from tests.models.predictors.small_training import BRIEF, small_training
from tests.pipeline.runs import runs

ORIGIN = Provenance("python -m rallygap.stages.segment", "f" * 64)


@pytest.fixture
def new_store(tmp_path, monkeypatch):
    """Where a store will be: in a repository with a space in its name."""
    home = tmp_path / "a repository"
    home.mkdir()
    monkeypatch.chdir(tmp_path)
    Path("dvc.yaml").write_text("stages: {ingest: {}, segment: {}}\n")
    monkeypatch.setenv("DVC_ROOT", str(home))
    monkeypatch.delenv("MLFLOW_TRACKING_URI", raising=False)
    return home / "mlflow.db"


@pytest.fixture
def store(new_store, empty_store):
    """A store that the stages of a test write."""
    shutil.copy(empty_store, new_store)
    return new_store


@pytest.fixture
def below_dvc(monkeypatch):
    """As if one DVC process started all stages of the test."""
    monkeypatch.setattr(tracking, "reproduction", lambda: "7-1")


def all_runs(store):
    return {run.info.run_name: run for run in runs(store.parent, "")}


def statuses(store):
    return {name: run.info.status for name, run in all_runs(store).items()}


def record(stage="segment", results=Results):
    with tracked_stage(stage, ORIGIN, {"seed": 1, "segment": {"gap": 0.1}}, results):
        pass


def test_a_stage_leaves_its_parameters_metrics_inputs_figures_and_tags(store, tmp_path):
    figure = tmp_path / "cuts.png"
    figure.write_bytes(b"drawn")
    errors = {"position": {"100": {"mean": 1.5}, "105": {"mean": 2.5}}}
    metrics = {"tt3d": errors, "v > 60 m/s": 3}
    data = InputData("recordings", str(tmp_path / "a.parquet"), 2, "ab12")
    record(results=lambda: Results(metrics, [data], [figure]))
    (run,) = all_runs(store).values()
    assert run.info.status == "FINISHED"
    assert run.data.params == {"seed": "1", "segment.gap": "0.1"}
    assert run.data.metrics == {"tt3d/position/mean": 2.5, "v _ 60 m_s": 3.0}
    curve = mlflow.MlflowClient().get_metric_history(run.info.run_id, "tt3d/position/mean")
    assert [(point.step, point.value) for point in curve] == [(100, 1.5), (105, 2.5)]
    (noted,) = run.inputs.dataset_inputs
    assert (noted.dataset.name, noted.dataset.digest) == ("recordings", "ab12")
    tags = run.data.tags
    assert (tags["dvc.stage"], tags["rallygap.fingerprint"]) == ("segment", ORIGIN.fingerprint)
    assert [path.read_bytes() for path in store.parent.rglob("cuts.png")] == [b"drawn"]


def test_losses_and_learning_rates_arrive_while_a_network_trains(store, tmp_path, capfd):
    training, data = small_training()
    with tracked_stage("train_predictor", ORIGIN, {}, Results):
        train(training, data, tmp_path / "checkpoints", live=live_run("small"))
        assert statuses(store) == {"train_predictor": "RUNNING"}
        metrics = all_runs(store)["train_predictor"].data.metrics
    assert metrics["small/validation"] == pytest.approx(training.curve[-1]["validation"], rel=1e-5)
    assert any(name.startswith("small/lr-") for name in metrics)
    assert statuses(store) == {"train_predictor": "FINISHED"}
    assert live_run("small") is None
    assert capfd.readouterr() == ("", "")


def test_stages_of_one_reproduction_share_a_parent_with_the_metrics_of_all(
    store, monkeypatch, below_dvc
):
    write_json(Path("reports/ingest/metrics.json"), {"arena": {"recordings": 7}})
    write_json(Path("reports/segment/metrics.json"), {"arena": {"episodes": 9}})
    monkeypatch.setenv("DVC_EXP_NAME", "amber-toad")
    record("ingest")
    record("segment")
    found = all_runs(store)
    assert set(found) == {"amber-toad", "ingest", "segment"}
    parent = found.pop("amber-toad")
    above = {run.data.tags["mlflow.parentRunId"] for run in found.values()}
    assert above == {parent.info.run_id}
    assert parent.data.metrics == {"ingest/arena/recordings": 7.0, "segment/arena/episodes": 9.0}


@pytest.mark.parametrize(
    ("stop", "status"), [(ZeroDivisionError, "FAILED"), (SystemExit, "KILLED")]
)
def test_a_stage_that_does_not_end_well_ends_its_reproduction(store, below_dvc, stop, status):
    with pytest.raises(stop), tracked_stage("ingest", ORIGIN, {}, Results):
        if stop is SystemExit:
            signal.raise_signal(signal.SIGTERM)
        raise stop
    assert statuses(store) == {"reproduction": status, "ingest": status}


def test_the_run_of_a_killed_stage_is_closed_by_the_next_one(store, monkeypatch):
    child = os.fork()
    if child == 0:
        monkeypatch.setattr(tracking, "reproduction", lambda: "7-1")
        with tracked_stage("ingest", ORIGIN, {}, Results):
            os.kill(os.getpid(), signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    assert os.WTERMSIG(status) == signal.SIGKILL
    record()
    expected = {"reproduction": "KILLED", "ingest": "KILLED", "segment": "FINISHED"}
    assert statuses(store) == expected


def test_half_of_a_store_is_in_nobodys_way(new_store, capfd):
    new_store.with_name("mlflow.db.new").write_bytes(b"half of the tables")
    record("ingest")
    assert statuses(new_store) == {"ingest": "FINISHED"}
    assert capfd.readouterr() == ("", "")


def only_warning(capfd):
    out, err = capfd.readouterr()
    assert out == ""
    (line,) = err.splitlines()
    assert line.startswith("rallygap: warning: MLflow has no complete record of segment: ")
    return line


@pytest.mark.parametrize(
    ("address", "hangs"),
    [
        ("http://127.0.0.1:{}", False),
        ("http://127.0.0.1:{}", True),
        ("sqlite:////dev/null/{}.db", False),
    ],
)
def test_a_store_that_is_down_or_hangs_costs_a_warning(
    new_store, monkeypatch, capfd, address, hangs
):
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_TIMEOUT", "1")
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        monkeypatch.setenv("MLFLOW_TRACKING_URI", address.format(port))
        if not hangs:
            server.close()
        record()
    assert re.search(f"/dev/null|unable to open|{port}", only_warning(capfd))


def test_a_locked_store_costs_a_warning(store, capfd):
    with closing(sqlite3.connect(store, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        record()
    assert "database is locked" in only_warning(capfd)


def test_a_store_that_goes_while_a_stage_works_costs_a_warning(store, capfd):
    with tracked_stage("segment", ORIGIN, {}, Results):
        shutil.rmtree(store.parent)
        live_run("small").log({"validation": 0.5}, 1)
    only_warning(capfd)
    assert mlflow.active_run() is None


def test_a_store_that_is_down_is_asked_once_and_does_not_stop_a_training(tmp_path, monkeypatch):
    asked = Mock(side_effect=ConnectionError)
    monkeypatch.setattr(mlflow, "log_metrics", asked)
    training, data = small_training()
    run = LiveRun("http://127.0.0.1:9", "a run that fails", "small")
    train(training, data, tmp_path / "checkpoints", live=run)
    assert len(training.curve) == BRIEF.epochs
    asked.assert_called_once()
