"""The whole pipeline on a fresh copy of the repository, as small as it gets."""

import hashlib
import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from pipeline.params import read_yaml
from pipeline.profiles import merged
from pipeline.provenance import run_cache_key
from tests.clone import cloned, rallygap, run

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    return cloned(tmp_path_factory.mktemp("clone") / "rallygap")


@pytest.fixture(scope="module")
def reproduced(clone):
    """The clone after an experiment with the profile `smoke`."""
    run(clone, "dvc", "exp", "run", "--name", "smoke", *rallygap(clone, "profile", "smoke").split())
    return clone


def digests(folder):
    return {
        path.relative_to(folder): hashlib.sha256(path.read_bytes()).hexdigest()
        for name in ("artifacts", "reports", "dvc.lock")
        for path in [folder / name, *(folder / name).rglob("*")]
        if path.is_file()
    }


def test_every_stage_leaves_its_report_and_the_page(reproduced):
    for stage in read_yaml(reproduced / "dvc.yaml")["stages"]:
        assert (reproduced / "reports" / stage / "contents.json").is_file()
    assert (reproduced / "reports" / "index.html").is_file()


def test_every_file_of_a_report_is_declared(reproduced):
    stages = read_yaml(reproduced / "dvc.yaml")["stages"].values()
    declared = {Path(path) for stage in stages for out in stage["outs"] for path in names(out)}
    declared |= {Path(path) for stage in stages for path in stage["deps"]}
    files = [path.relative_to(reproduced) for path in (reproduced / "reports").rglob("*.*")]
    assert [path for path in files if not declared & {path, *path.parents}] == []


def names(out):
    return [out] if isinstance(out, str) else list(out)


def test_a_second_reproduction_does_nothing(reproduced):
    before = digests(reproduced)
    assert "up to date" in run(reproduced, "dvc", "repro")
    assert digests(reproduced) == before


def test_a_forced_reproduction_gives_the_same_bytes(reproduced):
    before = digests(reproduced)
    run(reproduced, "dvc", "repro", "--force")
    assert digests(reproduced) == before


def test_a_killed_training_goes_on_to_the_same_bytes(reproduced):
    before = digests(reproduced)
    stage = subprocess.Popen(
        [sys.executable, "-m", "stages.train_predictor"],
        cwd=reproduced,
        env={**os.environ, "PYTHONPATH": str(reproduced)},
        start_new_session=True,
    )
    while not (left := list((reproduced / "scratch").rglob("last.ckpt"))):
        assert stage.poll() is None
        time.sleep(0.01)
    os.killpg(stage.pid, signal.SIGKILL)
    assert stage.wait() == -signal.SIGKILL
    assert not (reproduced / "artifacts" / "train_predictor").exists()
    run(reproduced, "dvc", "repro", "--force", "--single-item", "train_predictor")
    assert digests(reproduced) == before
    assert not any(path.exists() for path in left)


def test_the_fingerprint_follows_from_the_lock(reproduced):
    for stage, entry in read_yaml(reproduced / "dvc.lock")["stages"].items():
        dependencies = {one["path"]: one["md5"] for one in entry["deps"]}
        outputs = [one["path"] for one in entry["outs"]]
        params = entry["params"]["params.yaml"]
        key = run_cache_key(entry["cmd"], dependencies, params, outputs)
        contents = json.loads((reproduced / "reports" / stage / "contents.json").read_text())
        assert key.startswith(contents["fingerprint"])


def test_mlflow_has_a_parent_and_a_run_for_each_stage(reproduced):
    stages = set(read_yaml(reproduced / "dvc.yaml")["stages"])
    expected = {(name, "FINISHED") for name in ("smoke", *stages)}
    deadline = time.monotonic() + 60
    while recorded_runs(reproduced) != expected:  # on a busy machine, they come later
        assert time.monotonic() < deadline
        time.sleep(1)


def recorded_runs(repository):
    """Name and status of the experiment's run and of its children."""
    with sqlite3.connect(repository / "mlflow.db") as store:
        return set(
            store.execute(
                "WITH parent AS (SELECT run_uuid FROM runs WHERE name = 'smoke') "
                "SELECT name, status FROM runs WHERE run_uuid IN parent OR run_uuid IN "
                "(SELECT run_uuid FROM tags WHERE key = 'mlflow.parentRunId' AND value IN parent)"
            )
        )


def test_an_experiment_is_kept_without_a_trace_of_this_machine(reproduced):
    rallygap(reproduced, "keep", "smoke")
    kept = reproduced / "reports" / "smoke"
    reports, trained = reproduced / "reports", reproduced / "artifacts" / "train_predictor"
    for path in kept.rglob("*.*"):
        inside = path.relative_to(kept)
        assert str(reproduced).encode() not in path.read_bytes()
        if inside.parts[0] == "predictors":
            own = trained.joinpath(*inside.parts[1:]).read_bytes()
            assert path.read_bytes() == own.replace(b"`reports/", b"`reports/smoke/")
        elif inside.name not in ("run.json", "timings.json"):
            assert path.read_bytes() == (reports / inside).read_bytes()
    assert (kept / "predictors" / "transformer" / "weights.safetensors").exists()
    flags = rallygap(reproduced, "profile", "smoke").split()[1::2]
    command = json.loads((kept / "run.json").read_text())["command"]
    assert all(flag in command for flag in flags)


@pytest.mark.real
def test_the_measured_sets_are_run_and_kept_by_one_command(reproduced, real_data):
    profiles = reproduced / "profiles"
    small = merged(read_yaml(profiles / "real.yaml"), read_yaml(profiles / "smoke.yaml"))
    (profiles / "real.yaml").write_text(yaml.safe_dump(small))
    rallygap(reproduced, "real", str(real_data.resolve()))
    kept = reproduced / "reports" / "real"
    metrics = json.loads((kept / "evaluate_predictor" / "metrics.json").read_text())
    for name in ("spindoe", "tt3d", "isr_ball_prediction"):
        assert "transformer_fine_tuned" in metrics[name]
    texts = [path.read_bytes() for path in kept.rglob("*") if path.is_file()]
    assert not any(str(real_data.resolve()).encode() in text for text in texts)
