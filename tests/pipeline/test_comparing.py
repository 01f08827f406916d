"""Experiments are run, queued and compared as users of DVC expect, from any folder."""

import json
import os
import time

import pytest

from tests.clone import run
from tests.pipeline.example_experiments import CHANGED, TARGET
from tests.pipeline.runs import runs

pytestmark = pytest.mark.slow

SCORES = "reports/segment/metrics.json"

anywhere = pytest.mark.parametrize("below", [".", "docs"])


def asked(folder, *command, below="."):
    return json.loads(run(folder, *command, "--json", below=below))


def seen(path, below):
    """A path in the repository, as DVC and users name it from a folder below."""
    return os.path.relpath(path, below)


def test_an_experiment_in_a_copy_leaves_the_working_folder_alone(experiments):
    assert run(experiments, "git", "status", "--porcelain") == ""
    assert "up to date" in run(experiments, "dvc", "repro", TARGET)


@anywhere
def test_parameters_differ_by_what_was_changed(experiments, below):
    differences = asked(experiments, "dvc", "params", "diff", "HEAD", "strict", below=below)
    changed = differences[seen("params.yaml", below)]
    assert changed == {CHANGED: {"old": 16.0, "new": 4.0, "diff": -12.0}}


@anywhere
def test_metrics_differ_by_its_effect(experiments, below):
    differences = asked(experiments, "dvc", "metrics", "diff", "HEAD", "strict", below=below)
    changed = differences[seen(SCORES, below)]
    assert changed
    assert all(one["old"] != one["new"] for one in changed.values())


@anywhere
def test_figures_stand_side_by_side(experiments, below, tmp_path):
    page = tmp_path / "plots"
    run(experiments, "dvc", "plots", "diff", "HEAD", "strict", "--out", str(page), below=below)
    text = (page / "index.html").read_text()
    assert "losses.csv" in text and "HEAD" in text and "strict" in text


@anywhere
def test_all_experiments_are_shown_with_parameters_and_metrics(experiments, below):
    shown = asked(experiments, "dvc", "exp", "show", below=below)
    (start,) = (one for one in shown if one["rev"] != "workspace")
    (state,) = next(one for one in start["experiments"] if one["name"] == "strict")["revs"]
    params = state["data"]["params"]["params.yaml"]
    assert params["data"]["segment"]["outlier_cost"] == 4.0
    assert state["data"]["metrics"][SCORES]["data"] is not None


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
