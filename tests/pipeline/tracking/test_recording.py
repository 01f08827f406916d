"""Stages are recorded in MLflow, and no store can hold them up."""

import json
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import psutil
import pytest
from mlflow.data import from_pandas
from mlflow.types import Schema

from pipeline.runtime.errors import InputError
from pipeline.runtime.provenance import Provenance
from pipeline.tracking import recording as tracking
from pipeline.tracking.recorder import MlflowClient, columns, shortened
from pipeline.tracking.recording import recorded

ROOT = Path(__file__).parents[3]
ORIGIN = Provenance("python -m stages.segment", "f" * 64)
BALLS = pd.DataFrame({"ball": ["a", "b"], "bounces": [0, 1], "x": [0.1, 0.2], "in": [True, False]})
NOTHING = {"metrics": {}, "inputs": [], "figures": []}


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """A working directory of its own: stages leave locks and links in theirs."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("DVC_ROOT", str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))


@pytest.fixture(scope="session")
def empty_store(tmp_path_factory):
    """A store that MLflow made, which takes seconds."""
    path = tmp_path_factory.mktemp("store") / "mlflow.db"
    MlflowClient(f"sqlite:///{path}").search_experiments()
    return path


@pytest.fixture
def store(new_store, empty_store):
    """A store that the stages of a test write."""
    shutil.copy(empty_store, new_store)
    return new_store


@pytest.fixture
def new_store(tmp_path, monkeypatch):
    """Where a store will be: in a repository with a space in its name."""
    home = tmp_path / "a repository"
    home.mkdir()
    monkeypatch.setenv("DVC_ROOT", str(home))
    monkeypatch.delenv("MLFLOW_TRACKING_URI", raising=False)
    monkeypatch.setattr(tracking, "PATIENCE", 300)  # on a busy machine
    return home / "mlflow.db"


def rows(store, query):
    with sqlite3.connect(store) as connection:
        return connection.execute(query).fetchall()


def statuses(store):
    try:
        return dict(rows(store, "SELECT name, status FROM runs"))
    except sqlite3.OperationalError:  # the tables are being made
        return None


@contextmanager
def recorded_quickly(stage="segment", results=NOTHING):
    with recorded(stage, ORIGIN, {"seed": 1}, lambda: results):
        yield


def test_a_stage_leaves_its_parameters_metrics_inputs_figures_and_tags(store, tmp_path):
    figure = tmp_path / "cuts.png"
    figure.write_bytes(b"drawn")
    table = tmp_path / "a.parquet"
    BALLS.to_parquet(table)
    results = {
        "metrics": {
            "tt3d": {"position": {"100": {"mean": 1.5}, "105": {"mean": 2.5}}},
            "v > 60 m/s": 3,
        },
        "inputs": [{"name": "recordings", "source": str(table), "rows": 2, "digest": "ab12"}],
        "figures": [str(figure)],
    }
    with recorded("segment", ORIGIN, {"seed": 1, "segment": {"gap": 0.1}}, lambda: results):
        pass
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
    assert rows(store, "SELECT name, digest, dataset_schema FROM datasets") == [
        ("recordings", "ab12", columns(table))
    ]
    tags = dict(rows(store, "SELECT key, value FROM tags"))
    assert (tags["dvc.stage"], tags["dvc.lock_hash"]) == ("segment", ORIGIN.fingerprint)
    assert [path.read_bytes() for path in store.parent.rglob("cuts.png")] == [b"drawn"]


@pytest.mark.filterwarnings("ignore:Hint. Inferred schema")
def test_a_table_has_the_columns_that_mlflow_would_find(tmp_path):
    BALLS.to_parquet(tmp_path / "balls.parquet")
    described = json.loads(columns(tmp_path / "balls.parquet"))["mlflow_colspec"]
    assert Schema.from_json(json.dumps(described)) == from_pandas(BALLS).schema


def test_what_is_no_table_has_no_columns(tmp_path):
    (tmp_path / "sheets.jsonl").write_text("{}")
    folder = tmp_path / "balls.parquet"
    folder.mkdir()
    assert [columns(path) for path in (tmp_path / "sheets.jsonl", folder)] == [None, None]


def test_stages_of_one_reproduction_share_a_parent(store, monkeypatch):
    monkeypatch.setattr(tracking, "reproduction", lambda: "7-1")
    monkeypatch.setenv("DVC_EXP_NAME", "amber-toad")
    for stage in ("ingest", "segment"):
        with recorded_quickly(stage):
            pass
    assert set(statuses(store)) == {"amber-toad", "ingest", "segment"}
    parents = rows(store, "SELECT DISTINCT value FROM tags WHERE key = 'mlflow.parentRunId'")
    assert parents == rows(store, "SELECT run_uuid FROM runs WHERE name = 'amber-toad'")


def test_a_failed_stage_fails_its_reproduction(store, monkeypatch):
    monkeypatch.setattr(tracking, "reproduction", lambda: "7-1")
    with pytest.raises(ZeroDivisionError), recorded_quickly("ingest"):
        raise ZeroDivisionError
    with recorded_quickly("segment"):
        pass
    expected = {"reproduction": "FAILED", "ingest": "FAILED", "segment": "FINISHED"}
    assert statuses(store) == expected


def test_a_killed_stage_is_recorded_as_killed(store):
    lines = [
        "import os, signal",
        "from pipeline.runtime.provenance import Provenance",
        "from pipeline.tracking.recording import recorded",
        "with recorded('segment', Provenance('', 'f'), {}, dict):",
        "    os.kill(os.getpid(), signal.SIGKILL)",
    ]
    killed = subprocess.run([sys.executable, "-c", "\n".join(lines)], check=False)
    assert killed.returncode == -signal.SIGKILL
    wait_for(store, {"segment": "KILLED"})


def wait_for(store, expected):
    deadline = time.monotonic() + 60
    while statuses(store) != expected:
        assert time.monotonic() < deadline
        time.sleep(0.1)


def test_no_message_is_left_behind(store, monkeypatch, tmp_path):
    messages = tmp_path / "messages"
    messages.mkdir()
    monkeypatch.setattr(tracking.tempfile, "tempdir", str(messages))
    with recorded_quickly():
        pass
    monkeypatch.setenv("MLFLOW_TRACKING_URI", "sqlite:////dev/null/none.db")
    with recorded_quickly():
        pass
    assert list(messages.iterdir()) == []


def test_two_stages_at_once_are_both_recorded_in_a_new_store(new_store):
    with recorded_quickly("ingest"), recorded_quickly("segment"):
        pass
    assert statuses(new_store) == {"ingest": "FINISHED", "segment": "FINISHED"}


def only_warning(capfd):
    out, err = capfd.readouterr()
    assert out == ""
    (line,) = err.splitlines()
    return line


@pytest.mark.parametrize("store", ["http://127.0.0.1:{port}", "sqlite:////dev/null/{port}.db"])
def test_a_store_that_is_down_costs_a_warning(store, monkeypatch, capfd):
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    monkeypatch.setattr(tracking, "PATIENCE", 300)
    monkeypatch.setenv("MLFLOW_TRACKING_URI", store.format(port=port))
    with recorded_quickly():
        pass
    warning = only_warning(capfd)
    assert warning.startswith("rallygap: warning: MLflow has no complete record of segment: ")
    assert "/dev/null" in warning or str(port) in warning


def test_a_server_that_does_not_answer_costs_a_warning(monkeypatch, capfd):
    monkeypatch.setattr(tracking, "PATIENCE", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as server:
        monkeypatch.setenv("MLFLOW_TRACKING_URI", f"http://127.0.0.1:{server.getsockname()[1]}")
        with recorded_quickly():
            pass
    assert "slow or locked" in only_warning(capfd)


def test_a_locked_store_costs_a_warning_and_is_written_when_it_is_free(store, monkeypatch, capfd):
    with recorded_quickly("ingest"):
        pass
    monkeypatch.setattr(tracking, "PATIENCE", 2.0)
    with sqlite3.connect(store, isolation_level=None) as other:
        other.execute("BEGIN EXCLUSIVE")
        with recorded_quickly("segment"):
            pass
        other.execute("ROLLBACK")
    assert "slow or locked" in only_warning(capfd)
    wait_for(store, {"ingest": "FINISHED", "segment": "FINISHED"})


def test_the_store_is_the_repository_s_whatever_the_working_directory(monkeypatch, tmp_path):
    monkeypatch.delenv("DVC_ROOT", raising=False)
    monkeypatch.delenv("MLFLOW_TRACKING_URI", raising=False)
    monkeypatch.chdir(ROOT / "tests" / "pipeline")
    described = tracking.description("segment", ORIGIN, {})
    assert described["store"] == f"sqlite:///{ROOT / 'mlflow.db'}"
    monkeypatch.setenv("DVC_ROOT", str(tmp_path))  # as for an experiment in a temporary folder
    assert tracking.description("segment", ORIGIN, {})["store"] == f"sqlite:///{tmp_path}/mlflow.db"


def test_a_dvc_process_above_makes_a_reproduction(tmp_path):
    program = tmp_path / "dvc"
    show = "from pipeline.tracking.recording import reproduction; print(reproduction())"
    program.write_text(
        "import os, subprocess, sys\nprint(os.getpid(), flush=True)\n"
        f"subprocess.run([sys.executable, '-c', {show!r}])\n"
    )
    run = [sys.executable, str(program)]
    pid, key = subprocess.run(run, cwd=ROOT, capture_output=True, text=True).stdout.split()
    assert key.split("-")[0] == pid
    assert tracking.reproduction() is None


def test_long_parameters_are_cut_where_every_store_takes_them():
    assert shortened("x" * 300) == "x" * 249 + "…"
    assert shortened(["a", "é"]) == '["a", "é"]'


def test_a_recorder_killed_in_a_new_store_leaves_one_that_can_be_made(new_store, monkeypatch):
    monkeypatch.setattr(tracking, "PATIENCE", 300)
    unfinished = new_store.with_name("mlflow.db.new")
    unfinished.write_bytes(b"half of the tables")
    with recorded_quickly():
        pass
    assert statuses(new_store) == {"segment": "FINISHED"}
    assert not unfinished.exists()


def test_a_recorder_that_was_killed_costs_a_warning(store, monkeypatch, tmp_path, capfd):
    messages = tmp_path / "messages"
    messages.mkdir()
    monkeypatch.setattr(tracking.tempfile, "tempdir", str(messages))
    with recorded_quickly():
        children = psutil.Process().children()
        (recorder,) = (one for one in children if "pipeline.tracking.recorder" in one.cmdline())
        recorder.kill()
    assert only_warning(capfd).endswith("no complete record of segment: the recorder was killed")
    assert list(messages.iterdir()) == []


def test_no_room_for_messages_costs_a_warning(monkeypatch, capfd):
    def no_room(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tracking, "write_json", no_room)
    with recorded_quickly():
        pass
    expected = "MLflow has no record of segment: [Errno 28] No space left on device"
    assert only_warning(capfd) == f"rallygap: warning: {expected}"


def test_a_stage_whose_timings_find_no_room_is_recorded_as_failed(store, monkeypatch):
    def no_room(*_):
        raise OSError(28, "No space left on device", "timings")

    monkeypatch.setattr(tracking, "keep_timings", no_room)
    with pytest.raises(InputError, match="timings: the disk is full"), recorded_quickly():
        pass
    assert statuses(store) == {"segment": "FAILED"}


def test_a_stage_that_was_told_to_stop_is_recorded_as_killed(store):
    with pytest.raises(SystemExit), recorded_quickly():
        signal.raise_signal(signal.SIGTERM)
    assert statuses(store) == {"segment": "KILLED"}
