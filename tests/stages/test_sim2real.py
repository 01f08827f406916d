"""The stage on policies that chase the forecast ball: better forecasts give more hits."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.io.artifacts import read_as, read_json, read_table
from rallygap.pipeline.params import Sim2RealSettings
from rallygap.pipeline.policies.storage import save_policy
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.returns import ONCE
from rallygap.stages.sim2real import sim2real
from tests.pipeline.amendments import write_amended
from tests.pipeline.measured_shots import params
from tests.pipeline.replayed import LAUNCH, SETTINGS, SOURCE, launched, replayed, write_replays
from tests.pipeline.trained_policies import chaser, description
from tests.stages.outputs import table

PHYSICS, ORACLE = ("physics", "every_tick"), ("oracle", "every_tick")


def transferred(root, horizons=((115, 120, 125),), **changes):
    """The run on few shots."""
    shots = [replayed("arena/pro", number) for number in (4, 5)]
    states = LAUNCH + 0.02 * np.random.default_rng(0).normal(size=(SETTINGS.launches, 9))
    write_replays(root, shots, sources=("arena", "plain"), launches=launched(*states))
    for repeat in (0, 1):
        for ahead in horizons:
            trained = description(repeat=repeat, horizons=ahead)
            save_policy(root / "artifacts" / "train_policy" / trained.name, chaser(), trained)
    write_amended(root / "artifacts" / "close_gap", "arena", "imperfect_c", {"drag": {"cd": 0.54}})
    run = StageRun("sim2real", root, params(sim2real=SETTINGS.model_copy(update=changes)))
    sim2real(run)
    return run


def test_metrics_are_mean_return_rates(whole):
    metrics = read_json(whole.report("metrics.json"))
    rates = whole.kept("sim2real", "rates").groupby("predictor")["return_rate"].mean()
    found = {name: one["return_rate"] for name, one in metrics.items()}
    assert found == pytest.approx(rates.to_dict(), rel=1e-5)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """One run; not to be changed."""
    return transferred(tmp_path_factory.mktemp("whole"))


def test_the_physics_that_flew_the_balls_forecasts_them_best(whole):
    errors = table(whole, "rates", "set", "predictor", "protocol")["forecast_error_cm"]
    for name in ("stroke_pro", SOURCE):
        assert errors[name, *ORACLE] < errors[name, *PHYSICS] < errors[name, "tiny", "every_tick"]
        assert errors[name, *PHYSICS] < errors[name, "physics", "first_window"]
    amended = errors["stroke_pro", "amended", "every_tick"]
    assert errors["stroke_pro", *ORACLE] < amended < errors["stroke_pro", *PHYSICS]


def test_differences_are_between_the_rates_on_the_same_shots(whole):
    rates = table(whole, "rates", "set", "predictor", "protocol")["hit_rate"]
    keys = ("set", "predictor", "protocol", "outcome")
    for name, protocol in {"difference": "every_tick", "difference_first_window": ONCE}.items():
        gains = table(whole, name, *keys)["difference"]
        for one in ("stroke_pro", "plain", SOURCE):
            gain = rates[one, "tiny", "every_tick"] - rates[one, "physics", protocol]
            assert gains[one, "tiny", "every_tick", "hits"] == pytest.approx(gain, abs=1e-5)


def test_a_policy_meets_the_same_shots_whoever_else_plays_to_the_same_end(whole, tmp_path):
    again = transferred(tmp_path, ((115, 120, 125), (170, 175, 180)))
    played, before = (read_table(run.artifact("played.parquet")) for run in (again, whole))
    assert set(played["horizons_ms"]) == {"115-125", "170-180"}
    alike = played[played["horizons_ms"] == "115-125"].reset_index(drop=True)
    pd.testing.assert_frame_equal(alike, before)


def test_every_trial_of_every_policy_is_kept(whole):
    played = read_table(whole.artifact("played.parquet"))
    shots = {"stroke_pro": 2 * 5, "plain": 3 * 3, SOURCE: SETTINGS.launches * 4}
    assert played.groupby("set").size().to_dict() == {name: 2 * n for name, n in shots.items()}
    assert set(played["repeat"]) == {0, 1}
    same = played.groupby(["set", "predictor", "protocol", "ball"])["hit"].nunique()
    assert (same == 1).all()  # the policies are alike
    rows = table(whole, "replayed", "set")
    assert rows["replayed"].to_dict() == {"stroke_pro": 2, "plain": 3, SOURCE: SETTINGS.launches}
    assert rows["spin"]["plain"] == "none" and rows["physics"]["plain"] == "literature"
    path = whole.artifact("settings.json")
    assert read_as(path, Sim2RealSettings, "sim2real") == SETTINGS


def test_a_forecast_that_is_far_off_costs_hits(whole):
    hits = table(whole, "tolerance", "error", "size_cm")["hits"]
    assert hits["bias", 0.0] == hits["noise", 0.0] > 0
    assert hits["bias", 40.0] < hits["bias", 0.0]
    assert len(hits) == 5


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"learned": ["tiny", "gru_tae"]}, "no predictor gru_tae was trained; there are tiny"),
        ({"simulator": "imperfect_a"}, "no policy of small that was trained in imperfect_a"),
    ],
)
def test_what_was_not_trained_is_one_error_and_there_are_no_metrics(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        transferred(tmp_path, **change)
    assert not (tmp_path / "reports").exists()
