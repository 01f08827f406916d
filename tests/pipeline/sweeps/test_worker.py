"""Workers share a study; whatever becomes of one of them, the study goes on."""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest
from optuna.trial import TrialState

from pipeline.runtime.errors import InputError
from pipeline.sweeps.lost_trials import Signature
from pipeline.sweeps.storage import storage
from pipeline.sweeps.study import create_study, load_study, tried
from pipeline.sweeps.worker import trials_of
from tests.pipeline.sweeps.made_up import HEADS, RATE, ROOT, Valley, done, plan

# A worker in a process of its own, in the repository of argv[1], on the study of argv[2]. A trial
# after the first says so and stays at its first epoch while there is a file "hold" beside the data.
WORKER = """
import os, sys, time
from pathlib import Path
from pipeline.sweeps import storage, worker
from pipeline.sweeps.plan import load_plan
from tests.pipeline.sweeps.made_up import Valley, unrecorded

class Held(Valley):
    def score(self, params, folder, watch):
        print("begun", flush=True)
        while (root / "hold").exists():
            time.sleep(0.05)
        return super().score(params, folder, watch)

root = Path(sys.argv[1])
worker.trials_of, worker.recorded_trial, worker.LOOK_AGAIN = lambda plan: Held(), unrecorded, 0.1
storage.HEARTBEAT, storage.GRACE = 1, 3
url = os.environ.get(worker.STUDY)
worker.work(load_plan(root, "tiny"), sys.argv[2], int(sys.argv[3]), url, lambda line: None)
"""


# Makes the study of a repository as soon as its input ends.
MAKER = """
import os, sys
from pathlib import Path
from pipeline.sweeps import study, worker
from pipeline.sweeps.plan import load_plan

swept = load_plan(Path(sys.argv[1]), "tiny")
print("ready", flush=True)
sys.stdin.read()
study.create_study(swept, os.environ.get(worker.STUDY))
"""


# The command of argv[1:] in a process of its own.
MASTER = "import subprocess, sys; subprocess.run(sys.argv[1:])"


def surroundings(url):
    """The environment of a process that works on a study."""
    return {**os.environ, "PYTHONPATH": str(ROOT), **({"RALLYGAP_STUDY": url} if url else {})}


@contextmanager
def start(swept, study, wanted, url=None, master=()):
    """A worker, which must have ended at the end of the block; where that fails it is killed."""
    command = [*master, sys.executable, "-c", WORKER, str(swept.root), study, str(wanted)]
    told = {"stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=ROOT, env=surroundings(url), **told) as process:
        try:
            yield process
        except BaseException:
            process.kill()
            raise


def table(study):
    """What was tried and what came of it."""
    return [(one.number, one.state, one.params, one.value) for one in study.trials]


def states(study):
    return [one.state for one in study.trials]


def test_one_worker_tries_the_same_from_the_same_seed_and_finds_the_valley(tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    studies = []
    for root in (one, other):
        root.mkdir()
        studies.append(done(plan(root), 20))
    assert table(studies[0]) == table(studies[1])
    assert studies[0].best_value < 0.34 < studies[0].trials[0].value


def test_a_study_that_was_left_goes_on_as_if_it_had_not_been(tmp_path):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    for root in (whole, parts):
        root.mkdir()
    for wanted in (2, 7, 12):
        left = done(plan(parts), wanted)
        assert tried(left) == wanted
    assert table(left) == table(done(plan(whole), 12))


def test_the_first_trial_are_the_parameters_as_they_are(tmp_path):
    swept = plan(tmp_path)
    first = done(swept, 1).trials[0]
    assert first.params == swept.defaults()


def test_trials_that_lag_behind_are_given_up_early_and_count(tmp_path):
    study = done(plan(tmp_path), 15)
    given_up = [one for one in study.trials if one.state == TrialState.PRUNED]
    assert given_up
    assert all(one.last_step < 3 for one in given_up)
    assert min(one.intermediate_values[1] for one in given_up) > study.best_value
    assert tried(study) == 15


class Astray(Valley):
    """Trials whose loss is no number."""

    def score(self, params, folder, watch):
        watch(1, float("nan"))


def test_a_trial_that_goes_astray_is_given_up(tmp_path):
    assert states(done(plan(tmp_path), 2, Astray())) == [TrialState.PRUNED] * 2


def test_values_that_do_not_go_together_are_given_up(tmp_path):
    width = "train_predictor.networks.transformer.width"
    space = {HEADS: {"choices": [4, 8]}, width: {"choices": [60, 64]}}
    study = done(plan(tmp_path, space=space), 12)
    for one in study.trials:
        clash = (one.params[HEADS], one.params[width]) == (8, 60)
        assert (one.state == TrialState.PRUNED and not one.intermediate_values) == clash


class Interrupted(Valley):
    """Trials of which the second is interrupted from the keyboard."""

    trials = 0

    def score(self, params, folder, watch):
        self.trials += 1
        if self.trials == 2:
            raise KeyboardInterrupt
        return super().score(params, folder, watch)


def test_a_trial_that_was_interrupted_is_tried_again(tmp_path):
    swept = plan(tmp_path)
    with pytest.raises(SystemExit):
        done(swept, 3, Interrupted())
    study = done(swept, 3)
    assert states(study)[1] == TrialState.FAIL
    assert study.trials[2].params == study.trials[1].params
    assert tried(study) == 3


def test_a_trial_whose_worker_was_killed_is_tried_again_at_once(tmp_path):
    swept = plan(tmp_path)
    (tmp_path / "hold").touch()
    study = create_study(swept, None)
    with start(swept, study.study_name, 4) as worker:
        assert worker.stdout.readline() == "begun\n"
        worker.send_signal(signal.SIGKILL)
    assert states(study) == [TrialState.RUNNING]
    done(swept, 4)
    assert states(study)[0] == TrialState.FAIL
    assert study.trials[1].params == study.trials[0].params
    assert tried(study) == 4


def test_workers_end_with_the_command_that_started_them(tmp_path):
    swept = plan(tmp_path)
    (tmp_path / "hold").touch()
    study = create_study(swept, None)
    with start(swept, study.study_name, 4, master=(sys.executable, "-c", MASTER)) as command:
        assert command.stdout.readline() == "begun\n"
        command.send_signal(signal.SIGKILL)
        (tmp_path / "hold").unlink()
        assert command.stdout.read() == ""  # no other trial, and then nobody to begin one
    assert states(study) == [TrialState.RUNNING]


def test_a_trial_of_a_worker_that_lives_is_waited_for(tmp_path):
    swept = plan(tmp_path)
    study = create_study(swept, None)
    with Signature(swept.scratch / "workers") as other:
        trial = load_study(swept, study.study_name, None).ask()
        other.sign(trial)
        with Signature(swept.scratch / "workers") as signature:
            signature.retry_lost(study)
            assert states(study) == [TrialState.RUNNING]
    with Signature(swept.scratch / "workers") as signature:
        signature.retry_lost(study)
    assert states(study) == [TrialState.FAIL, TrialState.WAITING]


def test_a_trial_that_keeps_killing_its_workers_is_given_up(tmp_path):
    swept = plan(tmp_path)
    study = create_study(swept, None)
    for _ in range(6):
        with Signature(swept.scratch / "workers") as signature:
            signature.retry_lost(study)
            signature.sign(study.ask())
    tries = [one for one in study.trials if one.system_attrs.get("failed_trial", one.number) == 0]
    assert len(tries) == 4  # itself, and three more


@pytest.mark.parametrize("uses", [create_study, storage])
@pytest.mark.parametrize(
    "url",
    [
        "postgresql://ann:sesame@127.0.0.1:1/studies?sslpassword=simsalabim",
        "postgresql://ann:{sesame}@127.0.0.1:1/studies",
        "sesame",
    ],
)
def test_a_database_that_cannot_be_used_is_named_without_its_password(tmp_path, url, uses):
    with pytest.raises(InputError) as refused:
        uses(plan(tmp_path), url)
    assert "sesame" not in str(refused.value)
    assert "simsalabim" not in str(refused.value)


def test_a_sweep_without_balls_to_learn_from_says_so(tmp_path):
    with pytest.raises(InputError, match=r"manifest\.json"):
        trials_of(plan(tmp_path))


@pytest.mark.slow
def test_two_workers_share_a_study_in_postgresql_and_one_is_killed(tmp_path, postgres_url):
    swept = plan(tmp_path)
    (tmp_path / "hold").touch()
    study = create_study(swept, postgres_url)
    with (
        start(swept, study.study_name, 12, postgres_url) as killed,
        start(swept, study.study_name, 12, postgres_url) as other,
    ):
        assert killed.stdout.readline() == other.stdout.readline() == "begun\n"
        assert states(study) == [TrialState.RUNNING] * 2
        killed.send_signal(signal.SIGKILL)
        (tmp_path / "hold").unlink()
        assert other.wait(120) == 0
    assert states(study).count(TrialState.FAIL) == 1
    assert tried(study) == 12
    lost = next(one for one in study.trials if one.state == TrialState.FAIL)
    again = next(one for one in study.trials if one.system_attrs.get("failed_trial") == lost.number)
    assert again.params == lost.params
    assert again.state in (TrialState.COMPLETE, TrialState.PRUNED)
    assert len({one.params[RATE] for one in study.trials}) == len(study.trials) - 1


@pytest.mark.slow
def test_of_two_sweeps_that_start_at_once_on_an_empty_database_one_makes_the_study(
    tmp_path, postgres_url
):
    swept = plan(tmp_path)
    command = [sys.executable, "-c", MAKER, str(tmp_path)]
    told = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "env": surroundings(postgres_url)}
    with (
        subprocess.Popen(command, cwd=ROOT, **told) as one,
        subprocess.Popen(command, cwd=ROOT, **told) as other,
    ):
        assert one.stdout.readline() == other.stdout.readline() == b"ready\n"
        one.stdin.close()
        other.stdin.close()
        assert one.wait() == other.wait() == 0
    assert states(create_study(swept, postgres_url)) == [TrialState.WAITING]
