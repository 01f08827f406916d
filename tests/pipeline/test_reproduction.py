"""The whole pipeline on a fresh copy of the repository, as small as it gets."""

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import mlflow
import numpy as np
import pytest

from rallygap.models.predictors.protocol import History
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.predictors.storage import load_predictor
from rallygap.pipeline.tracking.headlines import HEADLINES
from rallygap.pipeline.tracking.model_registry import CHAMPION, SIGNATURE, current_champion
from tests.clone import cloned, rallygap, run
from tests.pipeline.runs import runs, store

pytestmark = pytest.mark.slow

REGISTERED = "predictor-arena"


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    return cloned(tmp_path_factory.mktemp("clone") / "rallygap")


@pytest.fixture(scope="module")
def flags(clone):
    """The profile `smoke` as flags; none are left once it has been applied."""
    return rallygap(clone, "profile", "smoke").split()


@pytest.fixture(scope="module")
def reproduced(clone, flags):
    """The clone after an experiment with the profile `smoke`."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MLFLOW_SYSTEM_METRICS_SAMPLING_INTERVAL", "1")  # s; such stages are short
        run(clone, "dvc", "exp", "run", "--name", "smoke", *flags)
    return clone


def experiment_runs(repository):
    """The experiment's run and those of its stages, by name."""
    found = runs(repository, "tags.`dvc.experiment` = 'smoke'")
    return {one.info.run_name: one for one in found}


@pytest.fixture(scope="module")
def tracked(reproduced):
    """The same runs, all of which have ended well."""
    found = experiment_runs(reproduced)
    assert set(found) == {"smoke", *read_yaml(reproduced / "dvc.yaml")["stages"]}
    assert {one.info.status for one in found.values()} == {"FINISHED"}
    return found


def digests(folder):
    return {
        path.relative_to(folder): hashlib.sha256(path.read_bytes()).hexdigest()
        for name in ("artifacts", "reports", "dvc.lock")
        for path in [folder / name, *(folder / name).rglob("*")]
        if path.is_file()
    }


def test_every_stage_leaves_its_metrics_and_the_page(reproduced):
    for stage in set(read_yaml(reproduced / "dvc.yaml")["stages"]) - {"report"}:
        assert (reproduced / "reports" / stage / "metrics.json").is_file()
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
        [sys.executable, "-m", "rallygap.stages.train_predictor"],
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


def test_mlflow_has_a_parent_and_a_run_for_each_stage(tracked):
    parents = {name: one.data.tags.get("mlflow.parentRunId") for name, one in tracked.items()}
    assert parents.pop("smoke") is None
    assert set(parents.values()) == {tracked["smoke"].info.run_id}


def test_a_stage_s_run_shows_what_the_machine_did(tracked):
    metrics = {name: [*one.data.metrics] for name, one in tracked.items()}
    assert any(one.startswith("system/") for one in metrics["train_policy"])
    assert not any(one.startswith("system/") for one in metrics["smoke"])


def test_the_experiment_s_run_has_what_changed_and_the_headlines_of_its_stages(tracked, flags):
    parent = tracked["smoke"].data
    changed = {one.lstrip("+~").split("=")[0] for one in flags[1::2]}
    assert changed and changed <= set(parent.params)
    assert {name.split("/")[0] for name in parent.metrics} == set(HEADLINES)
    for name in parent.params:
        assert f"changed.{name}" in tracked["segment"].data.tags


@pytest.fixture
def trained(reproduced, monkeypatch):
    """The folder of the trained predictors, with MLflow's own functions at the clone's store."""
    monkeypatch.setenv("MLFLOW_TRACKING_URI", f"sqlite:///{reproduced / 'mlflow.db'}")
    return reproduced / "artifacts" / "train_predictor"


def test_every_trained_predictor_is_registered_and_the_best_is_the_champion(reproduced, trained):
    report = reproduced / "reports" / "train_predictor" / "metrics.json"
    curves = json.loads(report.read_text()).items()
    losses = {name: epochs[max(epochs, key=int)]["validation"] for name, epochs in curves}
    assert set(losses) == {path.name for path in trained.iterdir()}
    assert {tags["predictor"] for tags in registered(reproduced)} == set(losses)
    assert champion(reproduced) == min(losses, key=losses.get)


def registered(repository):
    """The tags of every version."""
    return [one.tags for one in store(repository).search_model_versions(f"name = '{REGISTERED}'")]


def champion(repository):
    """The name of the predictor that is the champion; None where there is none yet."""
    found = current_champion(store(repository), REGISTERED)
    return found and found.tags["predictor"]


def test_the_champion_forecasts_as_the_predictor_that_was_trained(reproduced, trained):
    model = mlflow.pyfunc.load_model(f"models:/{REGISTERED}@{CHAMPION}")
    assert model.metadata.signature == SIGNATURE
    balls = model.input_example
    forecast = model.predict(balls)
    predictor = load_predictor(trained / champion(reproduced))
    expected = predictor.predict(History(balls["states"], balls["mask"]))
    assert np.isfinite(expected.states).all()
    np.testing.assert_array_equal(forecast["states"], expected.states)
    np.testing.assert_array_equal(forecast["spin_measured"], expected.spin_measured)
