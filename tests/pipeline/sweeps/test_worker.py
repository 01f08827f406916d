"""Workers share a study; it survives the death of any of them."""

import multiprocessing
import time
from contextlib import contextmanager
from functools import partial
from unittest.mock import Mock

import pandas as pd
import pytest
from optuna.trial import TrialState

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sweeps import study as study_module
from rallygap.pipeline.sweeps.study import PROCESS, ended, open_study, retry_lost, run_sweep
from tests.pipeline.sweeps.small_sweeps import HEADS, run, small_sweep, valley


def work(sweep, wanted, url, started):
    """Be a worker; a trial says so and waits while the file "hold" exists."""

    def held(params, folder, report):
        started.set()
        while (sweep.root / "hold").exists():
            time.sleep(0.05)
        return valley(params, folder, report)

    study_module.training_of = lambda sweep: held
    study_module.HEARTBEAT, study_module.GRACE = 1, 3
    run_sweep(sweep, url, wanted)


@contextmanager
def start(sweep, wanted, url=None):
    """A worker of a sweep that is at a trial, killed at the end of the block."""
    context = multiprocessing.get_context("fork")
    started = context.Event()
    process = context.Process(target=work, args=[sweep, wanted, url, started])
    process.start()
    try:
        assert started.wait(300)
        yield process
    finally:
        process.kill()
        process.join()


def table(study):
    return [(one.number, one.state, one.params, one.value) for one in study.trials]


def states(study):
    return [one.state for one in study.trials]


def test_a_resumed_study_tries_the_same_as_one_without_a_break(tmp_path):
    sweep = small_sweep(tmp_path / "resumed")
    for wanted in (2, 7, 12):
        assert ended(run(sweep, wanted)) == wanted
    whole = run(small_sweep(tmp_path / "whole"), 20)
    assert table(run(sweep, 20)) == table(whole)
    assert whole.trials[0].params == sweep.defaults()
    assert whole.best_value < 0.34 < whole.trials[0].value


@pytest.mark.parametrize("score", [float("nan"), float("inf")])
def test_trials_whose_score_is_not_finite_are_pruned_and_without_others_there_is_no_report(
    tmp_path, monkeypatch, score
):
    sweep = small_sweep(tmp_path, space={HEADS: [2, 8]})  # without the value of params.yaml
    monkeypatch.setattr(
        study_module, "training_of", lambda sweep: lambda params, folder, report: report(1, score)
    )
    with pytest.raises(InputError, match="no trial was completed"):
        run_sweep(sweep, None, 2)
    assert states(open_study(sweep, None)) == [TrialState.PRUNED] * 2
    assert not sweep.report.exists()


def test_values_that_are_invalid_together_are_pruned(tmp_path):
    width = "train_predictor.networks.transformer.width"
    space = {HEADS: [4, 8], width: [60, 64]}
    for one in run(small_sweep(tmp_path, space=space), 12).trials:
        invalid = (one.params[HEADS], one.params[width]) == (8, 60)
        assert (one.state == TrialState.PRUNED and not one.intermediate_values) == invalid


def test_a_trial_that_keeps_ending_its_worker_is_retried_three_times(tmp_path, monkeypatch):
    monkeypatch.setattr(study_module, "process_lives", lambda name: False)
    sweep = small_sweep(tmp_path)
    study = open_study(sweep, None)
    for _ in range(6):
        with pytest.raises(SystemExit):
            run(sweep, 10, Mock(side_effect=SystemExit(143)))
        retry_lost(study)
    first = [one for one in study.trials if one.params == sweep.defaults()]
    assert states(study)[:6] == [TrialState.FAIL] * 6
    assert len(first) == 4


def test_workers_share_a_study_and_the_next_one_retries_the_trial_of_a_killed_one(tmp_path):
    sweep = small_sweep(tmp_path)
    (tmp_path / "hold").touch()
    with start(sweep, 5) as lost, start(sweep, 5) as other:
        lost.kill()
        lost.join()
        with start(sweep, 5) as late:
            (tmp_path / "hold").unlink()
            other.join()
            late.join()
            assert (other.exitcode, late.exitcode) == (0, 0)
    study = open_study(sweep, None)
    assert ended(study) in (5, 6)  # both may begin a fifth
    assert_retried(study)
    assert len(pd.read_csv(sweep.report / "trials.csv")) == ended(study)


def assert_retried(study):
    """One trial was lost, and its parameters were tried again."""
    (failed,) = [one for one in study.trials if one.state == TrialState.FAIL]
    again = [one for one in study.trials if one.system_attrs.get("failed_trial") == failed.number]
    assert [one.params for one in again] == [failed.params]


def test_a_trial_of_a_worker_on_another_machine_is_left_to_it(tmp_path, monkeypatch):
    sweep, url = small_sweep(tmp_path), f"sqlite:///{tmp_path / 'studies.db'}"
    other = open_study(sweep, url).ask()
    other.set_user_attr(PROCESS, "999999-1")
    monkeypatch.setattr(study_module, "training_of", lambda sweep: valley)
    run_sweep(sweep, url, 1)
    assert states(open_study(sweep, url)) == [TrialState.RUNNING, TrialState.COMPLETE]


@pytest.mark.parametrize(
    "url",
    [
        "postgresql://ann:sesame@127.0.0.1:1/studies?sslpassword=simsalabim",
        "postgresql://ann:{sesame}@127.0.0.1:1/studies",
        "mysql://ann:sesame@127.0.0.1:1/studies",
        "sesame",
    ],
)
def test_a_database_that_cannot_be_used_is_named_without_its_password(tmp_path, url):
    with pytest.raises(InputError) as refused:
        open_study(small_sweep(tmp_path), url)
    assert "sesame" not in str(refused.value)
    assert "simsalabim" not in str(refused.value)


def test_a_sweep_without_data_says_what_is_enough(tmp_path):
    sweep = small_sweep(tmp_path)
    (tmp_path / "artifacts" / "segment").rmdir()
    with pytest.raises(InputError, match="`dvc repro segment` is enough"):
        run_sweep(sweep, None, 1)


@pytest.mark.slow
def test_two_machines_start_one_study_in_postgresql_and_one_is_killed(tmp_path, postgres_url):
    sweep = small_sweep(tmp_path)
    (tmp_path / "hold").touch()
    machine = partial(start, sweep, 8, postgres_url)
    open_study(sweep, postgres_url)  # two cannot make the tables at once
    with machine() as lost, machine() as other:
        study = open_study(sweep, postgres_url)
        assert states(study) == [TrialState.RUNNING] * 2
        lost.kill()
        time.sleep(4)  # until its heartbeat is stale
        (tmp_path / "hold").unlink()
        other.join()
        assert other.exitcode == 0
    assert ended(study) == 8
    assert_retried(study)
    assert len({str(one.params) for one in study.trials}) == len(study.trials) - 1
