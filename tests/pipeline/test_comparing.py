"""Experiments are run and compared as users of DVC expect, from any folder."""

import json

import pytest

from experiments.clone import run
from tests.pipeline.example_experiments import CHANGED, TARGET
from tests.pipeline.runs import runs

pytestmark = pytest.mark.slow


def test_an_experiment_in_a_copy_leaves_the_working_folder_alone(experiments, tmp_path):
    assert run(experiments, "git", "status", "--porcelain") == ""
    assert "up to date" in run(experiments, "dvc", "repro", TARGET)
    run(experiments, "dvc", "plots", "diff", "HEAD", "strict", "--out", str(tmp_path))
    assert "Validation loss" in (tmp_path / "index.html").read_text()
    changed = json.loads(run(experiments, "dvc", "params", "diff", "HEAD", "strict", "--json"))
    assert changed == {"params.yaml": {CHANGED: {"old": 16.0, "new": 4.0, "diff": -12.0}}}


def test_a_run_leads_to_its_experiment(experiments):
    (strict,) = runs(experiments, f"tags.`dvc.experiment` = 'strict' AND run_name = '{TARGET}'")
    assert strict.data.tags["dvc.baseline"] == run(experiments, "git", "rev-parse", "HEAD").strip()
    assert strict.data.tags["dvc.stage"] == TARGET
