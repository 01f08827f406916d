"""What a sweep found is left in a form that params.yaml takes, the same every time."""

import sqlite3

import pandas as pd
import pytest

from pipeline.experiments.profiles import merged
from pipeline.io.artifacts import read_json
from pipeline.params import check_params, read_yaml
from pipeline.runtime.errors import InputError
from pipeline.sweeps.plan import load_plan
from pipeline.sweeps.report import trials_table, write_report
from pipeline.sweeps.trial_tracking import recorded_trial
from tests.pipeline.sweeps.made_up import HEADS, RATE, ROOT, Valley, done, plan, unrecorded


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A sweep of some trials, and the flags it found; not to be changed."""
    own, study = _swept(tmp_path_factory.mktemp("swept"))
    return own, study, write_report(own, study)


def _swept(root):
    from pipeline.sweeps import worker

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(worker, "recorded_trial", unrecorded)
        own = plan(root)
        return own, done(own, 16)


def test_the_best_parameters_are_what_params_yaml_takes_and_what_was_tried(swept):
    own, study, flags = swept
    best = read_yaml(own.report / "best_params.yaml")
    params = check_params(merged(own.params, best), own.path)
    training = params.train_predictor.training
    assert training.learning_rate == pytest.approx(study.best_params[RATE], rel=5e-3)
    assert params.train_predictor.networks["transformer"].heads == study.best_params[HEADS]
    assert training.epochs == own.params["train_predictor"]["training"]["epochs"]
    assert f"{RATE}={training.learning_rate}" in flags


def test_the_table_has_every_trial(swept):
    own, study, _ = swept
    table = pd.read_csv(own.report / "trials.csv")
    assert table["trial"].tolist() == list(range(16))
    assert table.loc[study.best_trial.number, "score"] == pytest.approx(study.best_value, rel=1e-5)
    assert set(table["outcome"]) == {"finished", "given up"}
    assert (table["steps"][table["outcome"] == "finished"] == 3).all()
    summary = read_json(own.report / "sweep.json")
    assert summary["params_score"] == table["score"][0]
    assert summary["best_score"] == pytest.approx(table["score"][summary["best_trial"]])
    assert sum(summary["trials"].values()) == 16


def test_another_run_leaves_the_same_bytes(swept, tmp_path):
    own = swept[0]
    again, study = _swept(tmp_path)
    write_report(again, study)
    files = {path.name: path.read_bytes() for path in own.report.iterdir()}
    assert set(files) == {
        "best_params.yaml", "trials.csv", "sweep.json", "history.png", "importance.png"
    }  # fmt: skip
    assert {path.name: path.read_bytes() for path in again.report.iterdir()} == files


def test_what_another_sweep_finds_has_not_been_confirmed(tmp_path):
    own, study = _swept(tmp_path)
    write_report(own, study)
    confirmed = own.report / "confirmed.json"
    confirmed.write_text("{}")
    write_report(own, study)
    assert confirmed.exists()
    (own.report / "best_params.yaml").write_text("train_predictor: {}\n")
    write_report(own, study)
    assert not confirmed.exists()


def test_no_trial_is_given_up_in_its_first_steps(tmp_path, monkeypatch):
    monkeypatch.setattr("pipeline.sweeps.worker.recorded_trial", unrecorded)
    own = plan(tmp_path, pruning={"first_trials": 3, "first_steps": 1})
    table = trials_table(own, done(own, 16))
    assert table["steps"].min() == 2


class Nothing(Valley):
    """Trials of which none comes to anything."""

    def score(self, params, folder, watch):
        watch(1, float("inf"))


def test_a_sweep_of_which_no_trial_was_finished_leaves_nothing(tmp_path):
    own = plan(tmp_path)
    with pytest.raises(InputError, match="no trial was finished"):
        write_report(own, done(own, 2, Nothing()))
    assert not own.report.exists()


def test_trials_are_runs_of_mlflow_under_one_parent_that_a_failed_one_does_not_fail(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("DVC_ROOT", str(tmp_path))
    monkeypatch.delenv("MLFLOW_TRACKING_URI", raising=False)
    monkeypatch.setattr("pipeline.tracking.recording.PATIENCE", 300)
    own = plan(tmp_path)
    params = own.trial_params({RATE: 0.02})
    with pytest.raises(ZeroDivisionError), recorded_trial(own, "tiny-1", 0, params):
        raise ZeroDivisionError
    with recorded_trial(own, "tiny-1", 1, params) as record:
        record.scores.update({1: 0.5, 2: 0.25})
    with sqlite3.connect(tmp_path / "mlflow.db") as store:
        runs = store.execute("SELECT name, status FROM runs ORDER BY name").fetchall()
        parents = store.execute(
            "SELECT r.name FROM tags t JOIN runs r ON r.run_uuid = t.value "
            "WHERE t.key = 'mlflow.parentRunId'"
        ).fetchall()
        rates = store.execute(f"SELECT value FROM params WHERE key = '{RATE}'").fetchall()
        scores = store.execute("SELECT key, step, value FROM metrics ORDER BY step").fetchall()
    parent = "rallygap sweep tiny"
    assert runs == [(parent, "FINISHED"), ("trial 0", "FAILED"), ("trial 1", "FINISHED")]
    assert parents == [(parent,)] * 2
    assert rates == [("0.02",)] * 2
    assert scores == [("validation_loss", 1, 0.5), ("validation_loss", 2, 0.25)]


@pytest.mark.parametrize("name", ["predictor", "policy"])
def test_the_committed_sweep_has_all_its_trials_and_was_confirmed(name):
    kept = load_plan(ROOT, name)
    summary, confirmed = (read_json(kept.report / f"{one}.json") for one in ("sweep", "confirmed"))
    assert sum(summary["trials"].values()) == kept.settings.trials
    trials = pd.read_csv(kept.report / "trials.csv")
    finished = trials.loc[trials["outcome"] == "finished", "score"]
    smaller = summary["direction"] == "minimize"
    assert summary["best_score"] == pytest.approx(min(finished) if smaller else max(finished), 1e-5)
    differences = [*confirmed["per_seed"], confirmed["ci_low"], confirmed["ci_high"]]
    assert confirmed["holds"] == all(one < 0 if smaller else one > 0 for one in differences)
