"""Stages are recorded in MLflow, and a store that fails costs them one warning."""

import json
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import Provenance
from rallygap.pipeline.tracking import mlflow_run
from rallygap.pipeline.tracking import recording as tracking
from rallygap.pipeline.tracking.headlines import HEADLINES, headline_metrics
from rallygap.pipeline.tracking.mlflow_run import MlflowClient
from rallygap.pipeline.tracking.recording import InputData, Results, recorded

ROOT = Path(__file__).parents[3]
ORIGIN = Provenance("python -m rallygap.stages.segment", "f" * 64)


@pytest.fixture(scope="session")
def empty_store(tmp_path_factory):
    """A store that MLflow made, which takes seconds."""
    path = tmp_path_factory.mktemp("store") / "mlflow.db"
    MlflowClient(f"sqlite:///{path}").search_experiments()
    return path


@pytest.fixture
def new_store(tmp_path, monkeypatch):
    """Where a store will be: in a repository with a space in its name."""
    home = tmp_path / "a repository"
    home.mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("DVC_ROOT", str(home))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
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


def rows(store, query):
    with closing(sqlite3.connect(store)) as connection:
        return connection.execute(query).fetchall()


def statuses(store):
    return dict(rows(store, "SELECT name, status FROM runs"))


def tags(store, run):
    joined = "tags JOIN runs ON tags.run_uuid = runs.run_uuid"
    return dict(rows(store, f"SELECT key, value FROM {joined} WHERE name = '{run}'"))


def record(stage="segment", results=Results):
    with recorded(stage, ORIGIN, {"seed": 1, "segment": {"gap": 0.1}}, results):
        pass


def test_a_stage_leaves_its_parameters_metrics_inputs_figures_and_tags(store, tmp_path):
    figure = tmp_path / "cuts.png"
    figure.write_bytes(b"drawn")
    errors = {"position": {"100": {"mean": 1.5}, "105": {"mean": 2.5}}}
    metrics = {"tt3d": errors, "v > 60 m/s": 3}
    data = InputData("recordings", "a.parquet", 2, "ab12")
    record(results=lambda: Results(metrics, [data], [figure]))
    assert statuses(store) == {"segment": "FINISHED"}
    assert rows(store, "SELECT key, value FROM params ORDER BY key") == [
        ("seed", "1"),
        ("segment.gap", "0.1"),
    ]
    assert rows(store, "SELECT key, step, value FROM metrics ORDER BY key, step") == [
        ("tt3d/position/mean", 100, 1.5),
        ("tt3d/position/mean", 105, 2.5),
        ("v _ 60 m_s", 0, 3.0),
    ]
    assert rows(store, "SELECT name, digest FROM datasets") == [("recordings", "ab12")]
    found = tags(store, "segment")
    assert (found["dvc.stage"], found["rallygap.fingerprint"]) == ("segment", ORIGIN.fingerprint)
    assert [path.read_bytes() for path in store.parent.rglob("cuts.png")] == [b"drawn"]


def test_stages_of_one_reproduction_share_a_parent_with_their_headlines(
    store, monkeypatch, below_dvc
):
    monkeypatch.setenv("DVC_EXP_NAME", "amber-toad")
    record("ingest", lambda: Results({"arena": {"recordings": 7, "launches": 0}}))
    record("segment", lambda: Results({"arena": {"episodes": 9, "gaps": 1}}))
    assert set(statuses(store)) == {"amber-toad", "ingest", "segment"}
    parent = rows(store, "SELECT run_uuid FROM runs WHERE name = 'amber-toad'")
    assert rows(store, "SELECT value FROM tags WHERE key = 'mlflow.parentRunId'") == 2 * parent
    query = f"SELECT key, value FROM metrics WHERE run_uuid = '{parent[0][0]}' ORDER BY key"
    expected = [("ingest/arena/recordings", 7.0), ("segment/arena/episodes", 9.0)]
    assert rows(store, query) == expected


@pytest.mark.parametrize("stage", HEADLINES)
def test_every_headline_is_a_metric_of_the_committed_report(stage):
    metrics = json.loads((ROOT / "reports" / stage / "metrics.json").read_text())
    found = headline_metrics(stage, metrics)
    assert 0 < len(found) <= 30
    assert len({one.key for one in found}) == len(found)


def test_stages_that_dvc_skips_give_their_headlines_to_the_parent(store, below_dvc):
    write_json(Path("reports/ingest/metrics.json"), {"arena": {"recordings": 7}})
    write_json(Path("reports/sim2sim/metrics.json"), {"a": {"difference": {"mean": 1.0}}})
    shutil.copy(ROOT / "dvc.yaml", "dvc.yaml")
    record("segment")
    expected = [("ingest/arena/recordings", 7.0)]
    assert rows(store, "SELECT key, value FROM metrics") == expected


def test_a_headline_with_a_value_an_epoch_is_the_last_one():
    epochs = {str(epoch): {"training": 1.0, "validation": 1 / epoch} for epoch in (1, 2, 10)}
    (loss,) = headline_metrics("train_predictor", {"gru": epochs})
    assert (loss.key, loss.value) == ("train_predictor/gru/validation", 0.1)


def test_changed_parameters_are_shown_by_the_parent_and_its_stages(store, monkeypatch, below_dvc):
    home = store.parent
    (home / "params.yaml").write_text("seed: 1\nsegment: {gap: 0.1, cost: 16.0}\n")
    git = ["git", "-c", "user.name=a", "-c", "user.email=a@example.org"]
    for words in (["init"], ["add", "."], ["commit", "--message=start"]):
        subprocess.run([*git, *words], cwd=home, check=True, capture_output=True)
    Path("params.yaml").write_text("seed: 1\nsegment: {gap: 0.2, cost: 16.0, new: true}\n")
    record()
    parent = "run_uuid IN (SELECT run_uuid FROM runs WHERE name = 'reproduction')"
    changed = rows(store, f"SELECT key, value FROM params WHERE {parent} ORDER BY key")
    assert changed == [("segment.gap", "0.2"), ("segment.new", "true")]
    assert "| segment.gap | 0.1 | 0.2 |" in tags(store, "reproduction")["mlflow.note.content"]
    shown = {key: tag for key, tag in tags(store, "segment").items() if key.startswith("changed.")}
    assert shown == {
        "changed.segment.gap": "0.2 (committed: 0.1)",
        "changed.segment.new": "true (committed: absent)",
    }


def test_a_failed_stage_fails_its_reproduction(store, below_dvc):
    with pytest.raises(ZeroDivisionError), recorded("ingest", ORIGIN, {}, Results):
        raise ZeroDivisionError
    record()
    expected = {"reproduction": "FAILED", "ingest": "FAILED", "segment": "FINISHED"}
    assert statuses(store) == expected


def test_a_stage_stopped_by_a_signal_is_recorded_as_killed(store):
    with pytest.raises(SystemExit), recorded("segment", ORIGIN, {}, Results):
        signal.raise_signal(signal.SIGTERM)
    assert statuses(store) == {"segment": "KILLED"}


def test_the_run_of_a_killed_stage_is_closed_by_the_next_one(store):
    lines = [
        "import os, signal",
        "from rallygap.pipeline.runtime.provenance import Provenance",
        "from rallygap.pipeline.tracking import recording",
        "recording.reproduction = lambda: '7-1'",
        "with recording.recorded('ingest', Provenance('', 'f'), {}, recording.Results):",
        "    os.kill(os.getpid(), signal.SIGKILL)",
    ]
    killed = subprocess.run([sys.executable, "-c", "\n".join(lines)], check=False)
    assert killed.returncode == -signal.SIGKILL
    with recorded("segment", ORIGIN, {}, Results):
        pass
    expected = {"reproduction": "KILLED", "ingest": "KILLED", "segment": "FINISHED"}
    assert statuses(store) == expected


def test_stages_at_the_same_time_share_a_store_that_one_of_them_makes(new_store):
    new_store.with_name("mlflow.db.new").write_bytes(b"half of the tables")
    with recorded("ingest", ORIGIN, {}, Results), recorded("segment", ORIGIN, {}, Results):
        assert statuses(new_store) == {"ingest": "RUNNING", "segment": "RUNNING"}
    assert statuses(new_store) == {"ingest": "FINISHED", "segment": "FINISHED"}


def only_warning(capfd):
    out, err = capfd.readouterr()
    assert out == ""
    (line,) = err.splitlines()
    assert line.startswith("rallygap: warning: MLflow has no complete record of segment: ")
    return line


@pytest.mark.parametrize("address", ["http://127.0.0.1:{port}", "sqlite:////dev/null/{port}.db"])
def test_a_store_that_is_down_costs_a_warning(new_store, monkeypatch, capfd, address):
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    monkeypatch.setenv("MLFLOW_TRACKING_URI", address.format(port=port))
    record()
    warning = only_warning(capfd)
    assert "/dev/null" in warning or str(port) in warning


def test_a_server_that_does_not_answer_costs_a_warning(new_store, monkeypatch, capfd):
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_TIMEOUT", "1")
    with socket.create_server(("127.0.0.1", 0)) as server:
        monkeypatch.setenv("MLFLOW_TRACKING_URI", f"http://127.0.0.1:{server.getsockname()[1]}")
        record()
    assert "ReadTimeoutError" in only_warning(capfd)


def test_a_locked_store_costs_a_warning(store, monkeypatch, capfd):
    monkeypatch.setattr(mlflow_run, "STORE_BUSY", 0.1)
    with closing(sqlite3.connect(store, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        record()
    assert "database is locked" in only_warning(capfd)
    assert statuses(store) == {}


def test_a_dvc_process_above_makes_a_reproduction(tmp_path):
    program = tmp_path / "dvc"
    show = "from rallygap.pipeline.tracking.recording import reproduction; print(reproduction())"
    program.write_text(
        "import os, subprocess, sys\nprint(os.getpid(), flush=True)\n"
        f"subprocess.run([sys.executable, '-c', {show!r}])\n"
    )
    run = [sys.executable, str(program)]
    pid, key = subprocess.run(run, cwd=ROOT, capture_output=True, text=True).stdout.split()
    assert key.split("-")[0] == pid
    assert tracking.reproduction() is None


def test_a_stage_whose_timings_find_no_room_is_recorded_as_failed(store, monkeypatch):
    def no_room(*_):
        raise OSError(28, "No space left on device", "timings")

    monkeypatch.setattr(tracking, "keep_timings", no_room)
    with pytest.raises(InputError, match="timings: the disk is full"):
        record()
    assert statuses(store) == {"segment": "FAILED"}
