"""The report of a sweep: parameters that params.yaml accepts, and the same bytes every time."""

import shutil
from functools import partial

import optuna
import pandas as pd
import pytest

from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.params import check_params, read_yaml
from rallygap.pipeline.profiles import merged
from rallygap.pipeline.sweeps import study as trials
from rallygap.pipeline.sweeps.report import write_report
from rallygap.pipeline.sweeps.settings import Sweep
from rallygap.pipeline.tracking import runs as tracking
from tests.pipeline.runs import runs, store
from tests.pipeline.sweeps.small_sweeps import HEADS, RATE, ROOT, run, small_sweep, valley


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A sweep of 16 trials, its study and the flags of its report."""
    sweep = small_sweep(tmp_path_factory.mktemp("sweep"))
    study = run(sweep, 16)
    return sweep, study, write_report(sweep, study)


def test_params_yaml_accepts_the_best_parameters(swept):
    sweep, study, flags = swept
    best = read_yaml(sweep.report / "best_params.yaml")
    params = check_params(merged(sweep.params, best), sweep.path).train_predictor
    assert params.training.learning_rate == pytest.approx(study.best_params[RATE], rel=5e-3)
    assert params.networks["transformer"].heads == study.best_params[HEADS]
    assert params.training.epochs == sweep.params["train_predictor"]["training"]["epochs"]
    assert f"{RATE}={params.training.learning_rate}" in flags


def test_the_table_has_every_trial(swept):
    sweep, study, _ = swept
    table = pd.read_csv(sweep.report / "trials.csv")
    assert table["trial"].tolist() == list(range(16))
    assert table.loc[study.best_trial.number, "score"] == pytest.approx(study.best_value, rel=1e-5)
    assert set(table["outcome"]) == {"completed", "pruned"}
    assert (table["steps"][table["outcome"] == "completed"] == 3).all()
    summary = read_json(sweep.report / "sweep.json")
    assert summary["params_score"] == table["score"][0]
    assert summary["best_score"] == pytest.approx(table["score"][summary["best_trial"]])
    assert sum(summary["trials"].values()) == 16


def test_a_report_comes_again_with_the_same_bytes_and_another_result_is_not_confirmed(swept):
    sweep, study, _ = swept
    files = {path.name: path.read_bytes() for path in sweep.report.iterdir()}
    assert set(files) == {"best_params.yaml", "trials.csv", "sweep.json", "trials.png"}
    write_report(sweep, study)
    assert {path.name: path.read_bytes() for path in sweep.report.iterdir()} == files
    confirmed = sweep.report / "confirmed.json"
    confirmed.write_text("{}")
    write_report(sweep, study)
    assert confirmed.exists()
    (sweep.report / "best_params.yaml").write_text("train_predictor: {}\n")
    write_report(sweep, study)
    assert not confirmed.exists()


def failing_once(params, *trial):
    if params.train_predictor.training.learning_rate == 0.0625:
        raise ZeroDivisionError
    return valley(params, *trial)


def test_trials_are_nested_mlflow_runs_and_a_failed_one_does_not_fail_the_parent(
    tmp_path, monkeypatch, empty_store
):
    shutil.copy(empty_store, tmp_path)
    monkeypatch.setattr(trials, "tracked_run", tracking.tracked_run)
    monkeypatch.setenv("DVC_ROOT", str(tmp_path))
    monkeypatch.delenv("MLFLOW_TRACKING_URI", raising=False)
    sweep = small_sweep(tmp_path, space={RATE: [0.0625, 0.02]})
    study = optuna.create_study(study_name="tiny-1")
    for rate in (0.0625, 0.02):
        study.enqueue_trial({RATE: rate})
    study.optimize(partial(trials.run_trial, sweep, failing_once), 2, catch=ZeroDivisionError)
    found = {one.info.run_name: one for one in runs(tmp_path, "")}
    parent = found.pop("rallygap sweep tiny").info
    ends = {name: one.info.status for name, one in found.items()}
    assert (parent.status, ends) == ("FINISHED", {"trial 0": "FAILED", "trial 1": "FINISHED"})
    assert {one.data.tags["mlflow.parentRunId"] for one in found.values()} == {parent.run_id}
    assert [found[name].data.params[RATE] for name in sorted(ends)] == ["0.0625", "0.02"]
    losses = store(tmp_path).get_metric_history(found["trial 1"].info.run_id, "validation_loss")
    assert [one.step for one in losses] == [1, 2, 3]


@pytest.mark.parametrize("name", ["predictor", "policy"])
def test_the_committed_sweep_is_whole_and_confirmed_if_a_trial_is_better(name):
    sweep = Sweep(ROOT, name)
    summary = read_json(sweep.report / "sweep.json")
    assert sum(summary["trials"].values()) == sweep.settings.trials
    best = merged(sweep.params, read_yaml(sweep.report / "best_params.yaml"))
    assert (sweep.report / "confirmed.json").exists() == (best != sweep.params)
    if best != sweep.params:
        confirmed = read_json(sweep.report / "confirmed.json")
        sign = -1 if summary["direction"] == "minimize" else 1
        differences = [*confirmed["per_seed"], confirmed["ci_low"], confirmed["ci_high"]]
        assert confirmed["holds"] == all(sign * difference > 0 for difference in differences)
