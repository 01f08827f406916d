"""The study: its trials, with policies that chase the ball, and its tables."""

from itertools import product

import joblib
import numpy as np
import pandas as pd
import pytest

import experiments.stages.swap_study as run
from experiments import swap_study
from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.pipeline.policies.training import TrainingResult
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.replay_sets import read_replay_sets
from rallygap.pipeline.transfer.retraining import in_simulator
from tests.pipeline.amendments import write_amended
from tests.pipeline.measured_shots import params, write_trained
from tests.pipeline.replayed import LAUNCH, SETTINGS, launched, replayed, write_replays
from tests.pipeline.trained_policies import chaser, description

CURVE = pd.DataFrame({"control_steps": [48], "hit_rate": [1.0], "return_rate": [0.5]})
POLICIES = [(chaser(), description()), (chaser(3.0), description(repeat=1))]
PREDICTORS = {name: PhysicsPredictor(shipped("literature")) for name in swap_study.OF_MECHANISM}


@pytest.fixture(scope="module")
def shots(tmp_path_factory):
    states = LAUNCH + np.array([[0.0], [0.01]])
    root = tmp_path_factory.mktemp("replayed")
    folder = write_replays(root, sources=("plain",), launches=launched(*states))
    return read_replay_sets(folder, SETTINGS, 0)[-1]


def test_all_predictors_forecast_once_and_at_every_control_step(shots):
    trials = swap_study.reading_trials(shots, PREDICTORS, POLICIES, 0)
    kinds = [(one.forecaster.name, one.forecaster.mode) for one in trials]
    assert len(set(kinds)) == len(kinds) == 2 * len(PREDICTORS)
    table = swap_study.played(trials[-1], {"every_ms": "40"})
    assert table["recording"].tolist() == [*shots.recordings, *shots.recordings]
    assert table["repeat"].tolist() == [0, 0, 1, 1]
    assert set(table["every_ms"]) == {"40"}
    assert set(table["observation"]) == {POLICIES[0][1].observation}
    assert table["hit"].any()


def test_settings_differ_in_age_latency_and_labels(shots):
    found = list(swap_study.mechanism_trials(shots, PREDICTORS, POLICIES, 0))
    assert len(found) == len(swap_study.SETTINGS) * len(PREDICTORS)
    plain = next(trial for setting, trial in found if not setting.label_error)
    wrong = [trial for setting, trial in found if setting.label_error]
    states = [one.histories.history.states for one in (plain, *wrong)]
    assert np.abs(states[0] - states[1]).max() > 1
    for one in states[2:]:
        np.testing.assert_array_equal(one, states[1])
    hits = {
        trial.latency: trial.run().table["hit"].sum()
        for setting, trial in found
        if setting.every_ms == 40
        and not setting.label_error
        and trial.forecaster.name == "oracle"
        and setting.latency_ms in (0, 200)
    }
    assert hits[0.0] > hits[0.2]


def trained_policies(root, parameters, folder):
    """Policies that chase the ball, and the same in the amended simulator."""
    plain = [description(horizons=one) for one in ((115, 120, 125), (170, 175, 180))]
    amended = run.amended_simulator(root, parameters)
    again = [in_simulator(one, "arena", amended) for one in plain]
    return [TrainingResult(one, chaser(), CURVE, 1.0) for one in (*plain, *again)]


def test_a_killed_run_resumes_and_publishes_all_tables(tmp_path, monkeypatch):
    arena = [replayed("arena/pro", number) for number in (4, 5)]
    artifacts = write_replays(tmp_path, arena, sources=("arena",))
    write_amended(artifacts / "close_gap", "arena", "imperfect_c", {"drag": {"cd": 0.54}})
    write_trained(tmp_path, "transformer")
    plain = params(sim2real=SETTINGS)
    few = plain.train_policy.model_copy(update={"trials": 2})
    used = plain.model_copy(update={"train_policy": few})
    monkeypatch.setattr(run, "profile_params", lambda root, name: used)
    monkeypatch.setattr(run, "trained_policies", trained_policies)
    monkeypatch.setattr(swap_study, "SETTINGS", swap_study.SETTINGS[:2])
    made, trial = [], run.played

    def noted(one, columns):
        made.append(one)
        if len(made) == 4:
            raise KeyboardInterrupt
        return trial(one, columns)

    monkeypatch.setattr(run, "played", noted)
    with joblib.parallel_config(backend="sequential"):
        with pytest.raises(KeyboardInterrupt):
            run.swap_study(StageRun("swap_study", tmp_path, None))
        left = list((tmp_path / "scratch").rglob("*.parquet"))
        assert len(left) == 3 and not (tmp_path / "reports").exists()
        run.swap_study(StageRun("swap_study", tmp_path, None))
    assert len(pd.read_csv(tmp_path / "reports/swap_study/policies.csv")) == 4
    names = {path.name for path in (tmp_path / "reports/swap_study").iterdir()}
    assert {"policies.csv", "readings.csv", "gains.csv"} <= names


def outcomes(share, **columns):
    """Outcomes of three trainings on the shots of two sets, of which a share is returned."""
    random = np.random.default_rng(len(str(columns)))
    keys = product(range(3), ("stroke_pro", "receive"), range(12))
    table = pd.DataFrame(keys, columns=["repeat", "set", "ball"])
    returned = random.random(len(table)) < share
    recording = table["set"] + (table["ball"] // 2).astype(str)
    return table.assign(hit=True, returned=returned, recording=recording, **columns)


def test_tables_have_a_row_for_every_comparison():
    predictors, horizons = ("physics_c", "amended", "transformer"), ("115-125", "170-180")
    policies = list(product(("intercept", "strict"), horizons))
    played = {"readings": [], "mechanism": [], "retrained": []}
    for predictor, (observed, ahead) in product(predictors, policies):
        of = {"predictor": predictor, "observation": observed, "horizons_ms": ahead}
        for protocol, share in (("first_window", 0.2), ("every_tick", 0.9)):
            played["readings"].append(outcomes(share, protocol=protocol, **of))
        for every in ("40", "first window"):
            setting = {"every_ms": every, "latency_ms": 0, "label_error": 0.0}
            played["mechanism"].append(outcomes(0.5, protocol="1", **setting, **of))
        if observed == "intercept":
            played["retrained"].append(outcomes(0.95, protocol="every_tick", **of))
    tables = swap_study.study_tables({name: pd.concat(some) for name, some in played.items()})
    rows = {name: len(table) for name, table in tables.items()}
    assert rows["readings"] == 2 * rows["readings_all"] == 48  # two sets
    assert rows["gains_by_set"] == 2 * rows["gains"] == 2 * rows["gains_mechanism"] == 64
    assert rows["retrained"] == rows["gains_retrained"] == rows["gains_every_tick"] / 2 == 12
    gained = tables["gains_every_tick"].query("outcome == 'returns'")
    assert (gained["difference"] > 0.4).all()
    assert (gained["p_holm"] < 0.01).all()
