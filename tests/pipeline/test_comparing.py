"""Experiments are run, queued and compared as users of DVC expect, from any folder."""

import json
import os
import time

import pytest

from experiments.clone import run
from tests.pipeline.example_experiments import CHANGED, TARGET
from tests.pipeline.runs import runs

pytestmark = pytest.mark.slow


def seen(path, below):
    """A path in the repository, as DVC and users name it from a folder below."""
    return os.path.relpath(path, below)


def test_an_experiment_in_a_copy_leaves_the_working_folder_alone(experiments, tmp_path):
    assert run(experiments, "git", "status", "--porcelain") == ""
    assert "up to date" in run(experiments, "dvc", "repro", TARGET)
    run(experiments, "dvc", "plots", "diff", "HEAD", "strict", "--out", str(tmp_path))
    assert "losses.csv" in (tmp_path / "index.html").read_text()
    changed = json.loads(run(experiments, "dvc", "params", "diff", "HEAD", "strict", "--json"))
    assert changed == {"params.yaml": {CHANGED: {"old": 16.0, "new": 4.0, "diff": -12.0}}}


@pytest.mark.parametrize(("below", "costs"), [(".", "9.0,25.0"), ("docs", "36.0,49.0")])
def test_queued_experiments_run_one_after_the_other(experiments, below, costs):
    before = listed(experiments)
    changes = f"{seen('params.yaml', below)}:{CHANGED}={costs}"
    target = f"{seen('dvc.yaml', below)}:{TARGET}"
    run(experiments, "dvc", "exp", "run", "--queue", "-S", changes, target, below=below)
    run(experiments, "dvc", "queue", "start", below=below)
    deadline = time.monotonic() + 300
    while not set(states := queue(experiments, below)) <= {"Success"}:
        assert time.monotonic() < deadline and "Failed" not in states, states
        time.sleep(1)
    assert len(listed(experiments) - before) == 2


def listed(experiments):
    return set(run(experiments, "dvc", "exp", "list", "--name-only").split())


def queue(experiments, below):
    """The states of the queue's experiments."""
    rows = run(experiments, "dvc", "queue", "status", below=below).splitlines()[1:]
    words = {"Queued", "Running", "Success", "Failed"}
    return [word for row in rows for word in row.split() if word in words]


def test_a_run_leads_to_its_experiment(experiments):
    (strict,) = runs(experiments, f"tags.`dvc.experiment` = 'strict' AND run_name = '{TARGET}'")
    assert strict.data.tags["dvc.baseline"] == run(experiments, "git", "rev-parse", "HEAD").strip()
    assert strict.data.tags["dvc.stage"] == TARGET
