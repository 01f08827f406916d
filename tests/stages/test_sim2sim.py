"""The stage on policies that chase the forecast ball: better forecasts give more hits."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.policies.storage import save_policy
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.sim2sim import KEYS, sim2sim
from tests.pipeline.measured_shots import params
from tests.pipeline.trained_policies import chaser, description
from tests.stages.outputs import table

HORIZONS = (115, 120, 125)
POLICIES = [("imperfect_c", 0), ("imperfect_c", 1), ("ground_truth", 0)]


def save_chaser(root, simulator, repeat, horizons=HORIZONS):
    goals = params().train_policy.groups["sim2sim"].goals
    trained = description(
        group="sim2sim", simulator=simulator, horizons=horizons, goals=goals, repeat=repeat
    )
    save_policy(root / "artifacts/train_policy" / trained.name, chaser(6.0 - 3 * repeat), trained)


def judged(root, **changes):
    """The run on few balls."""
    settings = params().sim2sim.model_copy(update={"episodes": 24, **changes})
    run = StageRun("sim2sim", root, params(sim2sim=settings))
    sim2sim(run)
    return run


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """One run with all policies; not to be changed."""
    root = tmp_path_factory.mktemp("whole")
    for simulator, repeat in POLICIES:
        save_chaser(root, simulator, repeat)
    return judged(root)


def rows_of(run, name, simulator):
    return table(run, name, "simulator").loc[simulator].set_index("protocol")


def test_identical_simulators_differ_by_exactly_nothing(whole):
    rates = rows_of(whole, "return_rate", "ground_truth")
    exact, imperfect = (
        rates[rates["predictor"] == name].drop(columns="predictor")
        for name in ("ground_truth", "imperfect")
    )
    pd.testing.assert_frame_equal(exact, imperfect)
    assert (exact["return_rate"] > 0).all()
    rows = rows_of(whole, "difference", "ground_truth")
    assert (rows[["difference", "ci_low", "ci_high", "gained", "lost"]] == 0).all(axis=None)


def test_forecasts_by_the_true_simulator_are_exact_and_give_more_hits(whole):
    rows = rows_of(whole, "return_rate", "imperfect_c").set_index("predictor", append=True)
    error, hits = rows["forecast_error_m"], rows["hit_rate"]
    assert (error.xs("ground_truth", level=1) < 1e-5).all()
    assert error["first_state", "imperfect"] > 10 * error["re_anchored", "imperfect"] > 0.03
    assert hits["first_state", "ground_truth"] > hits["first_state", "imperfect"] + 0.05
    assert abs(hits["first_state", "ground_truth"] - hits["re_anchored", "ground_truth"]) < 0.05


def test_policies_of_one_setting_are_taken_together_and_metrics_are_mean_gains(whole):
    rates = whole.kept("sim2sim", "rates").set_index(KEYS).loc["first_state", "imperfect_c"]
    assert rates["per_seed"].map(len).tolist() == [2, 2]
    means = rates["per_seed"].map(np.mean).to_list()
    exact, imperfect = rates["return_rate"]
    assert [exact, imperfect] == pytest.approx(means, rel=1e-5)
    gains = table(whole, "difference", "simulator", "protocol")["difference"]
    assert gains["imperfect_c", "first_state"] == pytest.approx(exact - imperfect, abs=1e-5)
    metrics = read_json(whole.report("metrics.json"))
    found = {name: one["gain"] for name, one in metrics.items()}
    assert found == pytest.approx(gains.groupby("protocol").mean().to_dict(), abs=1e-5)


def test_a_policy_meets_the_same_balls_whoever_else_plays(whole, tmp_path):
    save_chaser(tmp_path, "ground_truth", 0)
    save_chaser(tmp_path, "ground_truth", 0, horizons=(170, 175, 180))
    again = judged(tmp_path, protocols=["re_anchored"]).kept("sim2sim", "rates").set_index(KEYS)
    before = whole.kept("sim2sim", "rates").set_index(KEYS)
    place = ("re_anchored", "ground_truth", "115-125")
    pd.testing.assert_frame_equal(again.loc[place], before.loc[place])
    assert set(again.index.get_level_values("horizons_ms")) == {"115-125", "170-180"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"group": "other"}, "no policy of the group other"),
        ({"ground_truth": "perfect"}, "there is no shipped simulator 'perfect'"),
    ],
)
def test_an_unknown_group_or_simulator_is_one_error_and_there_are_no_metrics(
    tmp_path, change, message
):
    save_chaser(tmp_path, "imperfect_c", 0)
    with pytest.raises(InputError, match=message):
        judged(tmp_path, **change)
    assert not (tmp_path / "reports").exists()
