"""Forecasts of a made-up measured set: every recording is tested once, by predictors of others."""

import numpy as np
import pandas as pd
import pytest
import torch

import experiments.stages.real_forecasts
from experiments.real_forecasts import FineTuning
from experiments.stages.real_forecasts import real_forecasts
from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.learned import build_network
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.models.predictors.small_training import BRIEF, TINY, TINY_HYBRID, network
from tests.pipeline.measured_shots import SIMULATOR, params, write_trained

TIMES = 0.005 * np.arange(90)
LEARNED = {"hybrid", "hybrid_ensemble", "transformer", "transformer_ensemble"}
PREDICTORS = {"physics_literature", "amended", *LEARNED}


@pytest.fixture
def stage(tmp_path, monkeypatch):
    """A run with tiny trained networks and a set of eight recordings."""
    folder = tmp_path / "data" / "csv"
    folder.mkdir(parents=True)
    random = np.random.default_rng(0)
    for number in range(8):
        ball = [0.05 * number, 1.3, 0.3, 0.2, -7.0 + 0.2 * number, 0.5, -150.0, 10.0, 5.0]
        places = SIMULATOR.fly(ball, TIMES).states[0, :, :3]
        rows = np.column_stack([TIMES, places + 0.002 * random.standard_normal(places.shape)])
        table = pd.DataFrame(rows, columns=["t", "x", "y", "z"])
        table.to_csv(folder / f"ball_{number}.csv", index=False)
    write_trained(tmp_path, "transformer")
    hybrid = build_network(TINY_HYBRID, shipped("imperfect_c_with_net"))
    write_trained(tmp_path, "hybrid", made=hybrid, network=TINY_HYBRID)
    tuned = params().train_predictor.model_copy(update={"training": BRIEF})
    few = tuned.fine_tuning.model_copy(update={"epochs": 1, "windows_per_episode": 1})
    used = params(train_predictor=tuned.model_copy(update={"fine_tuning": few}))
    monkeypatch.setenv("RALLYGAP_DATA", str(tmp_path / "data"))
    monkeypatch.setattr(experiments.stages.real_forecasts, "SETS", ("csv",))
    monkeypatch.setattr(experiments.stages.real_forecasts, "FOLDS", 2)
    return StageRun("real_forecasts", tmp_path, used)


def test_every_recording_is_tested_once_by_every_predictor(stage):
    real_forecasts(stage)
    table = pd.read_csv(stage.report("errors.csv"))
    rows = table.query("quantity == 'position' and bounce == 'all'")
    assert set(rows["predictor"]) == PREDICTORS
    assert rows.groupby("horizon_ms")["n"].nunique().eq(1).all()
    errors = rows.query("horizon_ms == 200").set_index("predictor")["mean"]
    assert errors["physics_literature"] < 40.0  # the truth; the set errs by 2 mm
    pairs = pd.read_csv(stage.report("differences.csv"))
    assert set(pairs["predictor"]) == {"hybrid", "hybrid_ensemble"}
    covered = pd.read_csv(stage.report("coverage.csv"))
    assert set(covered["predictor"]) == PREDICTORS
    assert covered["coverage"].between(0.0, 1.0).all() and covered["size_mm"].gt(0.0).all()


def test_a_hybrid_on_another_simulator_starts_from_its_forecasts(stage, tmp_path):
    hybrid = build_network(TINY_HYBRID, SIMULATOR)
    other = PhysicsPredictor(SIMULATOR.amended("drag", cd=0.3))
    (fold, _) = experiments.stages.real_forecasts._folds(stage.root / "data" / "csv", "csv")
    tuning = FineTuning(network(TINY), hybrid, BRIEF, 0)
    jobs = {one.name: one for one in tuning.jobs(fold, other, tmp_path)}
    assert set(jobs) == {f"{one}-csv-0" for one in ("transformer", "transformer_2", "hybrid")}
    started = jobs["hybrid-csv-0"].network
    assert (started.physics, hybrid.simulator) == (other, SIMULATOR)
    assert not started.network.projection.weight.any()
    scales = (one.normaliser.future_spread for one in (started, hybrid))
    assert not torch.equal(*scales)
