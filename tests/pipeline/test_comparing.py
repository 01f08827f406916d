"""Experiments are run, queued and compared as users of DVC expect, from any folder."""

import json
import time

import pytest

from tests.clone import rallygap, run
from tests.pipeline.experiments import CHANGED, TARGET
from tests.pipeline.runs import runs

pytestmark = pytest.mark.slow

SCORES = "reports/score_segmentation/metrics.json"


def asked(folder, *command):
    return json.loads(run(folder, *command, "--json"))


def test_an_experiment_in_a_copy_leaves_the_working_folder_alone(experiments):
    assert run(experiments, "git", "status", "--porcelain") == ""
    assert "up to date" in run(experiments, "dvc", "repro", TARGET)


def test_parameters_differ_by_what_was_changed(experiments):
    differences = asked(experiments, "dvc", "params", "diff", "HEAD", "strict")
    assert differences["params.yaml"] == {CHANGED: {"old": 16.0, "new": 4.0, "diff": -12.0}}


def test_metrics_differ_by_its_effect_from_any_folder(experiments):
    command = ["dvc", "metrics", "diff", "HEAD", "strict", "--json"]
    differences = json.loads(run(experiments, *command, below="docs"))
    changed = differences[f"../{SCORES}"]
    assert changed
    assert all(one["old"] != one["new"] for one in changed.values())


def test_figures_stand_side_by_side(experiments, tmp_path):
    page = tmp_path / "plots"
    run(experiments, "dvc", "plots", "diff", "HEAD", "strict", "--out", str(page))
    text = (page / "index.html").read_text()
    pictures = {path.name.split("_")[0] for path in (page / "static").iterdir()}
    assert pictures == {"HEAD", "strict"}
    assert all(path.name in text for path in (page / "static").iterdir())


def test_all_experiments_are_shown_with_parameters_and_metrics(experiments):
    (start,) = (
        one for one in asked(experiments, "dvc", "exp", "show") if one["rev"] != "workspace"
    )
    (only,) = start["experiments"]
    assert only["name"] == "strict"
    (state,) = only["revs"]
    assert state["data"]["params"]["params.yaml"]["data"]["segment"]["outlier_cost"] == 4.0
    assert state["data"]["metrics"][SCORES]["data"] is not None


def test_queued_experiments_run_one_after_the_other(experiments):
    command = ["dvc", "exp", "run", "--queue", "-S", f"{CHANGED}=9.0,25.0", TARGET]
    run(experiments, *command)
    run(experiments, "dvc", "queue", "start")
    deadline = time.monotonic() + 300
    while (states := queue(experiments)) != ["Success"] * 2:
        assert time.monotonic() < deadline and "Failed" not in states, states
        time.sleep(1)
    listed = run(experiments, "dvc", "exp", "list", "--name-only").split()
    assert len(listed) == 3


def queue(experiments):
    """The states of the queue's experiments."""
    rows = run(experiments, "dvc", "queue", "status").splitlines()[1:]
    words = {"Queued", "Running", "Success", "Failed"}
    return [word for row in rows for word in row.split() if word in words]


def test_a_result_leads_to_its_run_and_the_run_to_its_experiment(experiments):
    told = dict(
        line.split(maxsplit=1) for line in rallygap(experiments, "run-of", SCORES).splitlines()
    )
    (named,) = runs(experiments, f"attributes.run_id = '{told['run']}'")
    assert named.data.tags["dvc.experiment"] == told["experiment"]
    (strict,) = runs(experiments, f"tags.`dvc.experiment` = 'strict' AND run_name = '{TARGET}'")
    assert strict.data.tags["dvc.baseline"] == run(experiments, "git", "rev-parse", "HEAD").strip()
    assert strict.data.tags["dvc.stage"] == TARGET
