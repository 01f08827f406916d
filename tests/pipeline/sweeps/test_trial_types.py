"""Real trainings, very small: what a trial scores, and what confirms a sweep."""

import sqlite3
import subprocess
import sys
import time
from contextlib import nullcontext

import numpy as np
import pandas as pd
import pytest
from optuna import TrialPruned
from ruamel.yaml import YAML

from pipeline.experiments.profiles import merged
from pipeline.io.artifacts import read_json
from pipeline.params import load_params
from pipeline.policies import training as policy_training
from pipeline.policies.training import Pupil, train_policies
from pipeline.runtime.errors import InputError
from pipeline.sweeps.confirm import run_confirm
from pipeline.sweeps.lost_trials import WORKER
from pipeline.sweeps.paired_comparison import Judged
from pipeline.sweeps.plan import load_plan
from pipeline.sweeps.policy_trial import described
from pipeline.sweeps.study import load_study
from pipeline.sweeps.trial_tracking import recorded_trial
from pipeline.sweeps.worker import trials_of
from pipeline.tracking import recording as tracking
from tests.models.policy.schooling import BRIEF
from tests.pipeline.measured_shots import shot_tables, write_inputs
from tests.pipeline.sweeps.made_up import RATE, ROOT, TINY, plan, write_yaml
from tests.services import PASSWORD

NETWORK = "train_predictor.networks.transformer"
TINY_TRAINING = {
    "train_predictor.training.epochs": 2,
    f"{NETWORK}.width": 16,
    f"{NETWORK}.expanded": 32,
}
LEARNING = "train_policy.groups.sim2sim.learning"
POLICY = {
    "trains": "policy", "group": "sim2sim", "simulator": "imperfect_c",
    "horizons_ms": [115, 120, 125], "trials": 2, "in_trials": {},
    "space": {f"{LEARNING}.discount": {"low": 0.9, "high": 0.99}},
    "pruning": {"first_trials": 3, "first_steps": 0},
}  # fmt: skip


@pytest.fixture(autouse=True)
def one_process(monkeypatch):
    """Train in this process, where other processes would take seconds to start."""
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "1")
    monkeypatch.setattr(policy_training, "TRIALS", 6)


def predictor_plan(root):
    splits = ["train"] * 4 + ["validation"] * 2
    shots = [shot_tables("arena/club", number, split=one) for number, one in enumerate(splits)]
    write_inputs(root, shots=shots, sources=("arena",))
    return plan(root, in_trials=TINY_TRAINING)


def policy_plan(root):
    return plan(root, **{**dict.fromkeys(TINY), **POLICY})


def test_a_predictor_is_scored_by_its_validation_loss_after_every_epoch(tmp_path):
    swept = predictor_plan(tmp_path)
    trials, seen = trials_of(swept), []
    params = swept.trial_params({RATE: 0.01})
    score = trials.score(params, tmp_path / "one", lambda *told: seen.append(told))
    training = trials.trained(params, tmp_path / "other")
    assert seen == [(row["epoch"], row["validation"]) for row in training.curve]
    assert score == seen[-1][1]


def test_a_predictor_that_lags_behind_is_trained_no_further(tmp_path):
    swept = predictor_plan(tmp_path)
    epochs = []

    def watch(epoch, loss):
        epochs.append(epoch)
        raise TrialPruned

    with pytest.raises(TrialPruned):
        trials_of(swept).score(swept.trial_params({RATE: 0.01}), tmp_path / "trial", watch)
    assert epochs == [1]


def brief(params):
    group = params.train_policy.groups["sim2sim"].model_copy(update={"learning": BRIEF})
    policies = params.train_policy.model_copy(update={"groups": {"sim2sim": group}, "trials": 10})
    return params.model_copy(update={"train_policy": policies})


def test_a_policy_is_scored_by_the_returns_of_watched_balls_after_every_leg(tmp_path):
    swept, seen = policy_plan(tmp_path), []
    params = brief(swept.trial_params({}))
    score = trials_of(swept).score(params, tmp_path / "trial", lambda *told: seen.append(told))
    pupil = Pupil(described(swept.settings, params), tmp_path / "stage")
    curve = train_policies([pupil])[0].curve
    assert seen == list(enumerate(curve["return_rate"], start=1))
    assert score == seen[-1][1]


def judged(params, found, smaller=True):
    measured = np.array([params, found], dtype=float)[..., None]
    groups = np.tile(np.arange(measured.shape[2]), (measured.shape[1], 1))
    return Judged(["error"], smaller, measured[0], measured[1], groups).table(seed=0).iloc[0]


def test_what_is_better_on_every_ball_and_with_every_seed_holds():
    random = np.random.default_rng(0)
    hard = random.uniform(10, 20, (3, 40))
    better = judged(hard, hard - random.uniform(0.1, 0.3, (3, 40)))
    assert better["holds"]
    assert better["difference"] == pytest.approx(better["found"] - better["params"])
    assert -0.3 < better["ci_low"] < better["difference"] < better["ci_high"] < -0.1
    assert not judged(hard, hard + 0.2)["holds"]
    assert judged(hard, hard + 0.2, smaller=False)["holds"]


def test_what_one_seed_contradicts_or_chance_may_have_made_does_not_hold():
    random = np.random.default_rng(0)
    hard = random.uniform(10, 20, (3, 40))
    contradicted = hard - np.array([[0.5], [0.5], [-0.01]])
    assert judged(hard, contradicted)["ci_high"] < 0
    assert not judged(hard, contradicted)["holds"]
    noise = random.normal(0, 1, 40)
    assert not judged(hard, hard + noise - noise.mean() - 0.01)["holds"]


def confirmed(swept, best):
    write_yaml(swept.report / "best_params.yaml", best)
    return run_confirm(swept)


def small(root, **changes):
    """Let the full trainings of a repository be small, too."""
    params = root / "params.yaml"
    settings = YAML(typ="safe").load(params.read_text())
    write_yaml(params, merged(settings, changes))


def test_predictors_are_confirmed_on_test_windows_with_three_seeds(tmp_path):
    predictor_plan(tmp_path)
    # At its first step the learning rate is zero.
    network = {"transformer": {"width": 16}}
    small(tmp_path, train_predictor={"training": {"epochs": 3}, "networks": network})
    swept = load_plan(tmp_path, "tiny")
    table = confirmed(swept, {"train_predictor": {"training": {"learning_rate": 0.02}}})
    assert table["measure"].tolist()[:2] == [
        "position error, 100 to 300 ms (mm)",
        "position error at 100 ms (mm)",
    ]
    assert len(table) == 10
    assert (table.loc[1:3, "params"].diff().dropna() > 0).all()  # errors grow with the horizon
    seeds = table.loc[0, ["seed_1", "seed_2", "seed_3"]]
    assert len(set(seeds)) == 3
    assert table.loc[0, "difference"] == pytest.approx(seeds.mean())
    summary = read_json(swept.report / "confirmed.json")
    assert summary["holds"] == bool(table.loc[0, "holds"])
    assert not (swept.scratch / "confirm").exists()


def test_policies_are_confirmed_on_unseen_balls_with_three_seeds(tmp_path):
    policy_plan(tmp_path)
    groups = {"sim2sim": {"learning": BRIEF.model_copy(update={"legs": 1}).model_dump()}}
    small(tmp_path, train_policy={"groups": groups, "trials": 10})
    swept = load_plan(tmp_path, "tiny")
    group = {"sim2sim": {"learning": {"discount": 0.9}}}
    table = confirmed(swept, {"train_policy": {"groups": group}})
    assert table["measure"].tolist() == ["return rate", "hit rate"]
    assert table["n"].tolist() == [30, 30]
    assert table["params"].between(0, 1).all()


def test_there_is_nothing_to_confirm_before_a_sweep_nor_once_it_was_adopted(tmp_path):
    swept = plan(tmp_path)
    with pytest.raises(InputError, match="run `rallygap sweep tiny`"):
        run_confirm(swept)
    rate = load_params(ROOT / "params.yaml").train_predictor.training.learning_rate
    with pytest.raises(InputError, match="says already"):
        confirmed(swept, {"train_predictor": {"training": {"learning_rate": rate}}})


def swept_by_two(root, **environment):
    """Let the command line do a sweep of four trials with two workers; return all that it said."""
    (root / "pyproject.toml").touch()
    (root / "tmp").mkdir(exist_ok=True)
    places = {"PATH": "/usr/bin:/bin", "HOME": str(root), "TMPDIR": str(root / "tmp")}
    environment |= {"PYTHONPATH": str(ROOT), **places}
    program = [sys.executable, "-c", "from pipeline.cli import main; main()", "sweep", "tiny"]
    command = [*program, "--workers", "2", "--trials", "4"]
    run = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert f"All of it: {root}/reports/sweeps/tiny\n" in run.stdout
    await_recorders(root / "tmp")
    return run.stdout + run.stderr


def await_recorders(temporary):
    """On a busy machine they outlive the sweep; with the last message gone they have written."""
    deadline = time.monotonic() + 300
    while list(temporary.glob("rallygap-*")):
        assert time.monotonic() < deadline
        time.sleep(0.1)


def assert_recorded(root):
    """Every trial of the report is a finished run of MLflow within that of the sweep."""
    trials = pd.read_csv(root / "reports" / "sweeps" / "tiny" / "trials.csv")
    assert len(trials) >= 4  # two workers may begin the last trial at once
    with sqlite3.connect(root / "mlflow.db") as store:
        runs = store.execute(
            "SELECT run.name, run.status, parent.name FROM runs run "
            "LEFT JOIN tags t ON t.run_uuid = run.run_uuid AND t.key = 'mlflow.parentRunId' "
            "LEFT JOIN runs parent ON parent.run_uuid = t.value"
        ).fetchall()
    sweep = "rallygap sweep tiny"
    nested = {(f"trial {number}", "FINISHED", sweep) for number in trials["trial"]}
    assert sorted(runs) == sorted({(sweep, "FINISHED", None), *nested})


@pytest.mark.slow
def test_the_command_line_sweeps_with_two_workers_and_records_every_trial(tmp_path):
    predictor_plan(tmp_path)
    for _ in range(2):  # the second time there is nothing left to do
        swept_by_two(tmp_path)
    assert_recorded(tmp_path)
    assert not (tmp_path / "scratch" / "sweeps" / "tiny" / "trials").exists()


@pytest.mark.slow
def test_a_sweep_in_postgresql_records_every_trial_and_leaves_the_password_nowhere(
    tmp_path, postgres_url
):
    swept = predictor_plan(tmp_path)
    said = swept_by_two(tmp_path, RALLYGAP_STUDY=postgres_url)
    assert_recorded(tmp_path)
    trials = load_study(swept, swept.study, postgres_url).trials
    assert len({trial.user_attrs[WORKER] for trial in trials}) == 2
    kept = [path for path in tmp_path.rglob("*") if path.is_file()]
    places = {path.relative_to(tmp_path).parts[0] for path in kept}
    assert {"mlflow.db", "reports", "scratch"} <= places
    assert not [path for path in kept if PASSWORD.encode() in path.read_bytes()]
    assert PASSWORD not in said


@pytest.mark.parametrize("ends", [nullcontext(), pytest.raises(TrialPruned)])
def test_a_trial_of_which_mlflow_cannot_be_told_goes_on(tmp_path, monkeypatch, capsys, ends):
    def no_room(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tracking, "Recorder", no_room)
    swept = plan(tmp_path)
    with ends, recorded_trial(swept, "a study", 3, swept.trial_params({})):
        if not isinstance(ends, nullcontext):
            raise TrialPruned
    assert "MLflow has no record of trial 3" in capsys.readouterr().err
