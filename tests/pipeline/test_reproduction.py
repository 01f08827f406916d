"""The whole pipeline on a fresh copy of the repository, as small as it gets."""

import hashlib
import ipaddress
import os
import re
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import mlflow
import numpy as np
import pytest
import yaml

from experiments.clone import cloned, environment, rallygap, run
from rallygap.models.predictors.protocol import History
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.predictors.storage import load_predictor
from rallygap.pipeline.profiles import merged
from tests.pipeline.runs import runs, store
from tests.services import listening
from tests.stage_files import outputs, paths

pytestmark = pytest.mark.slow


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
    """What a run leaves, by path; dvc.lock as it is read, since DVC writes it in any order."""
    files = {
        path.relative_to(folder): hashlib.sha256(path.read_bytes()).hexdigest()
        for name in ("artifacts", "reports")
        for path in (folder / name).rglob("*")
        if path.is_file()
    }
    return {**files, Path("dvc.lock"): read_yaml(folder / "dvc.lock")}


def test_every_file_of_a_report_is_declared(reproduced):
    stages = read_yaml(reproduced / "dvc.yaml")["stages"]
    declared = {Path(path) for stage in stages.values() for path in paths(outputs(stage))}
    folders = [reproduced / "reports" / stage for stage in stages]
    files = [path.relative_to(reproduced) for folder in folders for path in folder.rglob("*.*")]
    assert [path for path in files if not declared & {path, *path.parents}] == []


def test_a_second_reproduction_does_nothing_and_a_forced_one_gives_the_same_bytes(reproduced):
    before = digests(reproduced)
    assert "up to date" in run(reproduced, "dvc", "repro")
    assert digests(reproduced) == before
    assert not beyond_loopback(listened(reproduced, "dvc", "repro", "--force"))
    assert digests(reproduced) == before


def listened(folder, *command):
    """The addresses on which a command and the processes below it listen, until it ends well."""
    found = set()
    with subprocess.Popen(command, cwd=folder, env=environment(folder)) as started:
        while started.poll() is None:
            found |= listening(started.pid)
            time.sleep(0.2)
    assert started.returncode == 0
    return found


def beyond_loopback(addresses):
    return {address for address in addresses if not ipaddress.ip_address(address).is_loopback}


def test_the_probe_sees_who_listens_beyond_loopback():
    with socket.create_server(("0.0.0.0", 0)), socket.create_server(("127.0.0.1", 0)):
        assert beyond_loopback(listening(os.getpid())) == {"0.0.0.0"}


def stages_run(output):
    return re.findall(r"Running stage '(\w+)'", output)


def test_a_parameter_that_is_changed_back_takes_its_results_from_the_cache(reproduced):
    before = digests(reproduced)
    params = reproduced / "params.yaml"
    original = params.read_bytes()
    shorter = merged(read_yaml(params), {"train_predictor": {"training": {"epochs": 1}}})
    params.write_text(yaml.safe_dump(shorter))
    assert stages_run(run(reproduced, "dvc", "repro", "train_predictor")) == ["train_predictor"]
    assert digests(reproduced) != before
    params.write_bytes(original)
    assert stages_run(run(reproduced, "dvc", "repro")) == []
    assert digests(reproduced) == before


@pytest.mark.parametrize(
    ("file", "rerun"),
    [
        ("pipeline/report/train_predictor.py", ["report"]),
        ("pipeline/web/figure_style.py", ["report"]),
        ("docs/results.md", []),
    ],
    ids=["caption", "colour", "page"],
)
def test_no_result_depends_on_how_it_is_shown(reproduced, file, rerun):
    before = (reproduced / file).read_bytes()
    (reproduced / file).write_bytes(before + b"\n# edited\n")
    assert stages_run(run(reproduced, "dvc", "repro", "--dry")) == rerun
    (reproduced / file).write_bytes(before)


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


def test_mlflow_has_a_run_for_each_stage_below_one_of_the_experiment(reproduced, tracked, flags):
    parents = {name: one.data.tags.get("mlflow.parentRunId") for name, one in tracked.items()}
    assert parents.pop("smoke") is None
    assert set(parents.values()) == {tracked["smoke"].info.run_id}
    metrics = {name: [*one.data.metrics] for name, one in tracked.items()}
    assert any(one.startswith("system/") for one in metrics["train_policy"])
    assert not any(one.startswith("system/") for one in metrics["smoke"])
    changed = {one.lstrip("+~").split("=")[0] for one in flags[1::2]}
    assert changed and changed <= set(tracked["smoke"].data.params)
    with_metrics = {name.split("/")[0] for name in metrics["smoke"]}
    assert with_metrics == set(read_yaml(reproduced / "dvc.yaml")["stages"]) - {"report"}
    for stage, ending in (("train_predictor", "/validation"), ("train_policy", "/return_rate")):
        assert any(name.endswith(ending) for name in metrics[stage])


def test_every_trained_model_is_registered_and_the_champion_forecasts_as_it(
    reproduced, monkeypatch
):
    monkeypatch.setenv("MLFLOW_TRACKING_URI", f"sqlite:///{reproduced / 'mlflow.db'}")
    trained = reproduced / "artifacts" / "train_predictor"
    predictors = {
        f"predictor-{path.parent.name}-arena" for path in trained.glob("*/predictor.json")
    }
    folders = (reproduced / "artifacts" / "train_policy").glob("*/policy.json")
    policies = {f"policy-{path.parent.name}" for path in folders}
    names = {model.name for model in store(reproduced).search_registered_models()}
    assert predictors | policies <= names
    model = mlflow.pyfunc.load_model("models:/predictor-transformer-arena@champion")
    balls = model.input_example
    forecast = model.predict(balls)
    predictor = load_predictor(trained / "transformer")
    expected = predictor.predict(History(balls["states"], balls["mask"]))
    assert np.isfinite(expected.states).all()
    np.testing.assert_array_equal(forecast["states"], expected.states)
    np.testing.assert_array_equal(forecast["spin_measured"], expected.spin_measured)
