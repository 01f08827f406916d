"""Real trainings, very small: the score of a trial, and the confirmation of a sweep."""

import sqlite3
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from optuna import TrialPruned
from typer.testing import CliRunner

from rallygap.pipeline.cli import app
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.policies import training as policy_training
from rallygap.pipeline.policies.training import TrainingJob, train_policies
from rallygap.pipeline.profiles import merged
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sweeps.comparison import comparison
from rallygap.pipeline.sweeps.confirm import compared_params, run_confirm
from rallygap.pipeline.sweeps.policy import described
from rallygap.pipeline.sweeps.predictor import PredictorTraining
from rallygap.pipeline.sweeps.settings import Sweep
from rallygap.pipeline.sweeps.study import open_study, training_of
from tests.models.policy.schooling import BRIEF
from tests.pipeline.measured_shots import shot_tables, write_inputs
from tests.pipeline.sweeps.small_sweeps import RATE, ROOT, SETTINGS, small_sweep, write_yaml
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
    "horizons_ms": [115, 120, 125], "trials": 2,
    "in_trials": {f"{LEARNING}.{name}": value for name, value in BRIEF.model_dump().items()},
    "space": {f"{LEARNING}.discount": {"low": 0.9, "high": 0.99}},
    "pruning": {"first_trials": 3, "first_steps": 0},
}  # fmt: skip


@pytest.fixture(autouse=True)
def one_process(monkeypatch):
    """Train in this process, where other processes would take seconds to start."""
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "1")
    monkeypatch.setattr(policy_training, "VALIDATION_SHOTS", 6)


def predictor_sweep(root):
    splits = ["train"] * 4 + ["validation"] * 2
    shots = [shot_tables("arena/club", number, split=one) for number, one in enumerate(splits)]
    write_inputs(root, shots=shots, sources=("arena",))
    return small_sweep(root, in_trials=TINY_TRAINING)


def policy_sweep(root, **changes):
    return small_sweep(root, **{**dict.fromkeys(SETTINGS), **POLICY, **changes})


def test_a_predictor_is_scored_by_its_validation_loss_after_every_epoch(tmp_path):
    sweep, reports = predictor_sweep(tmp_path), []
    params = sweep.trial_params({RATE: 0.01})
    training = PredictorTraining(tmp_path, sweep.settings, params)
    score = training.score(params, tmp_path / "trial", lambda *one: reports.append(one))
    fitted = training.fit(params, tmp_path / "trial")  # it is done
    assert reports == [(row["epoch"], row["validation"]) for row in fitted.curve]
    assert score == reports[-1][1]

    def prune(*report):
        reports.append(report)
        raise TrialPruned

    with pytest.raises(TrialPruned):
        training_of(sweep)(params, tmp_path / "pruned", prune)
    assert len(reports) == 3  # it is trained no further


def test_a_policy_is_scored_by_its_return_rate_after_every_iteration(tmp_path):
    sweep, reports = policy_sweep(tmp_path), []
    params = sweep.trial_params({})
    score = training_of(sweep)(params, tmp_path / "trial", lambda *one: reports.append(one))
    job = TrainingJob(described(sweep.settings, params), tmp_path / "trial")
    curve = train_policies([job])[0].curve  # they are done
    assert reports == list(enumerate(curve["return_rate"], start=1))
    assert score == reports[-1][1]


def test_the_weights_of_the_reward_can_be_searched(tmp_path):
    weight = "train_policy.reward.contact"
    sweep = policy_sweep(tmp_path, space={weight: {"low": 0.1, "high": 1.0}})
    assert sweep.trial_params({weight: 0.9}).train_policy.reward.contact == 0.9


def compared(params, found, smaller=True):
    results = np.concatenate([params, found])[..., None]
    groups = np.tile(np.arange(params.shape[1]), (len(params), 1))
    return comparison(["error"], smaller, results, groups, seed=0).iloc[0]


def test_a_difference_holds_on_every_shot_and_with_every_seed_alone():
    random = np.random.default_rng(0)
    hard = random.uniform(10, 20, (3, 40))
    better = compared(hard, hard - random.uniform(0.1, 0.3, (3, 40)))
    assert better["holds"]
    assert better["difference"] == pytest.approx(better["found"] - better["params"])
    assert -0.3 < better["ci_low"] < better["difference"] < better["ci_high"] < -0.1
    assert not compared(hard, hard + 0.2)["holds"]
    assert compared(hard, hard + 0.2, smaller=False)["holds"]
    contradicted = compared(hard, hard - np.array([[0.5], [0.5], [-0.01]]))
    assert contradicted["ci_high"] < 0 and not contradicted["holds"]
    noise = random.normal(0, 1, 40)
    assert not compared(hard, hard + noise - noise.mean() - 0.01)["holds"]


def test_best_parameters_are_read_under_todays_names_and_without_an_alias(tmp_path):
    sweep = small_sweep(tmp_path)
    with pytest.raises(InputError, match="run `rallygap sweep tiny`"):
        run_confirm(sweep)
    best = {"train_predictor": {"training": {"longest_gradient": 4.31}}}
    write_yaml(sweep.report / "best_params.yaml", best)
    assert compared_params(sweep)[1].train_predictor.training.max_gradient_norm == 4.31
    (sweep.report / "best_params.yaml").write_text("a: &a {b: *a}")
    with pytest.raises(InputError, match=r"best_params\.yaml: is not plain YAML"):
        compared_params(sweep)


def confirmed(root, best, **full):
    """Confirm parameters by full trainings that are small, too."""
    write_yaml(root / "params.yaml", merged(read_yaml(root / "params.yaml"), full))
    sweep = Sweep(root, "tiny")
    write_yaml(sweep.report / "best_params.yaml", best)
    return run_confirm(sweep)


def test_predictors_are_confirmed_on_test_windows_with_three_seeds(tmp_path):
    sweep = predictor_sweep(tmp_path)
    # At its first step the learning rate is zero.
    full = {"training": {"epochs": 3}, "networks": {"transformer": {"width": 16}}}
    best = {"train_predictor": {"training": {"learning_rate": 0.02}}}
    table = confirmed(tmp_path, best, train_predictor=full)
    assert table.loc[0, "measure"] == "position error, 100 to 300 ms (mm)"
    assert len(table) == 10
    assert (table.loc[1:3, "params"].diff().dropna() > 0).all()  # errors grow with the horizon
    seeds = table.loc[0, ["seed_1", "seed_2", "seed_3"]]
    assert len(set(seeds)) == 3
    assert table.loc[0, "difference"] == pytest.approx(seeds.mean())
    summary = read_json(sweep.report / "confirmed.json")
    assert summary["holds"] == bool(table.loc[0, "holds"])
    assert not (sweep.scratch / "confirm").exists()


def test_policies_are_confirmed_on_unseen_shots_with_three_seeds(tmp_path):
    policy_sweep(tmp_path)
    learning = {**BRIEF.model_dump(), "iterations": 1}
    full = {"groups": {"sim2sim": {"learning": learning}}, "trials": 10}
    best = {"train_policy": {"groups": {"sim2sim": {"learning": {"discount": 0.9}}}}}
    table = confirmed(tmp_path, best, train_policy=full)
    assert table["measure"].tolist() == ["return rate", "hit rate"]
    assert table["n"].tolist() == [30, 30]
    assert table["params"].between(0, 1).all()


def test_there_is_nothing_to_confirm_if_no_trial_is_better_than_params(tmp_path, monkeypatch):
    sweep = small_sweep(tmp_path)
    write_yaml(sweep.report / "best_params.yaml", {"seed": sweep.params["seed"]})
    (tmp_path / "pyproject.toml").touch()
    monkeypatch.chdir(tmp_path)
    said = CliRunner().invoke(app, ["confirm", "tiny"])
    assert said.exit_code == 0
    assert "there is nothing to confirm" in said.output
    assert not (sweep.report / "confirmed.csv").exists() and not sweep.scratch.exists()


def sweep_with_two_workers(root, **environment):
    """Run a sweep of four trials with two workers from the command line; return their output."""
    (root / "pyproject.toml").touch()
    environment |= {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "HOME": str(root)}
    program = [sys.executable, "-c", "from rallygap.pipeline.cli import main; main()"]
    options = {"cwd": root, "env": environment, "text": True}
    workers = [
        subprocess.Popen(
            [*program, "sweep", "tiny", "--trials", "4"],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options,
        )
        for _ in range(2)
    ]  # fmt: skip
    outputs = [worker.communicate()[0] for worker in workers]
    assert [worker.returncode for worker in workers] == [0, 0], outputs
    assert all(f"Report: {root}/reports/sweeps/tiny\n" in output for output in outputs)
    return "".join(outputs)


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
@pytest.mark.parametrize("database", [None, "postgres_url"])
def test_two_workers_record_every_trial_and_leave_no_password(tmp_path, request, database):
    predictor_sweep(tmp_path)
    study = {}
    if database is not None:
        study = {"RALLYGAP_STUDY": request.getfixturevalue(database)}
        open_study(Sweep(tmp_path, "tiny"), study["RALLYGAP_STUDY"])  # two cannot make the tables
    for _ in range(2):  # the second time there is nothing left to do
        assert PASSWORD not in sweep_with_two_workers(tmp_path, **study)
    assert_recorded(tmp_path)
    kept = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert {"mlflow.db", "reports"} <= {path.relative_to(tmp_path).parts[0] for path in kept}
    assert not [path for path in kept if PASSWORD.encode() in path.read_bytes()]
