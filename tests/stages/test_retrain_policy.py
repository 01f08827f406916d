"""The stage after sim2real: the same balls, policies trained in other simulators, one table."""

import json

import numpy as np
import pandas as pd
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.io.artifacts import read_table, write_table
from rallygap.pipeline.params import RetrainPolicySettings
from rallygap.pipeline.policies import training as policy_training
from rallygap.pipeline.policies.storage import load_policies, save_policy
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.retrain_policy import retrain_policy
from rallygap.stages.sim2real import sim2real
from tests.models.policy.schooling import BRIEF
from tests.pipeline.amendments import write_amended
from tests.pipeline.measured_shots import params
from tests.pipeline.replayed import SETTINGS, replayed, write_replays
from tests.pipeline.trained_policies import chaser, description
from tests.stages.outputs import table

AMENDED = {"drag": {"cd": 0.54}, "wind": {"x": 0.2}}
SPELLED = BRIEF.model_copy(update={"iterations": 1})


def prepared(root):
    """A run after sim2real, where balls of the arena amended simulator C."""
    shots = [replayed("arena/pro", 4), replayed("arena/pro", 5, replay_set="receive")]
    write_replays(root, shots, sources=("arena",))
    write_amended(root / "artifacts" / "close_gap", "arena", "imperfect_c", AMENDED)
    trained = description(learning=SPELLED)
    policies = root / "artifacts" / "train_policy"
    save_policy(policies / trained.name, chaser(), trained)
    save_unseen(policies, trained)
    settings = RetrainPolicySettings(sources=["arena"])
    known = params(sim2real=SETTINGS, retrain_policy=settings)
    sim2real(StageRun("sim2real", root, known))
    return StageRun("retrain_policy", root, known, "f" * 64)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """One run, in this process; not to be changed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LOKY_MAX_CPU_COUNT", "1")
        patch.setattr(policy_training, "VALIDATION_SHOTS", 6)
        run = prepared(tmp_path_factory.mktemp("whole"))
        retrain_policy(run)
    return run


def save_unseen(policies, trained):
    """The report of train_policy on balls of its own simulator and of another one."""
    unseen = pd.DataFrame({"ball": range(10), **trained.labels})
    unseen = unseen.assign(hit=unseen["ball"] < 8, returned=unseen["ball"] < 6)
    elsewhere = unseen.assign(simulator="imperfect_a", hit=True, returned=True)
    write_table(policies / policy_training.TEST_TRIALS, pd.concat([unseen, elsewhere]))


def test_policies_differ_from_those_before_in_their_simulator_alone(whole):
    ((_, described),) = load_policies(whole.artifact(""), "small")
    expected = shipped("imperfect_c").amended("drag", cd=0.54).amended("wind", x=0.2)
    assert described.task.simulator == expected
    assert described.model_copy(
        update={"simulator": "imperfect_c", "effects": description().effects}
    ) == description(learning=SPELLED)


def test_every_policy_meets_every_predictor_on_the_same_balls(whole):
    rows = table(whole, "returns", "set")
    pairs = [("original", name) for name in ("physics", "tiny", "amended", "oracle")]
    pairs += [("retrained", name) for name in ("tiny", "amended", "oracle")]
    for name, balls in {"arena": 2, "stroke_pro": 1, "receive": 1}.items():
        own = rows.loc[name]
        assert list(zip(own["policy"], own["predictor"], strict=True)) == pairs
        assert (own["balls"] == balls).all()
    played = read_table(whole.artifact("played.parquet"))
    before = read_table(whole.input("sim2real", "played.parquet"))
    before = before[before["protocol"] == "every_tick"].reset_index(drop=True)
    own = played[played["policy"] == "original"].drop(columns="policy").reset_index(drop=True)
    pd.testing.assert_frame_equal(own, before)
    goals = played.groupby(["set", "ball"])["goal_landing_along"].nunique()
    assert (goals == 1).all()  # old and new policies are asked the same


def test_all_policies_play_in_their_own_simulators(whole):
    rows = table(whole, "own_simulator", "simulator")
    assert rows["balls"].to_dict() == {"imperfect_c": 10, "amended_by_arena": 10}
    assert rows.loc["imperfect_c", ["hits", "returns"]].tolist() == [8, 6]  # as written above
    metrics = json.loads(whole.report("metrics.json").read_text())
    assert set(metrics) == {"original", "retrained"}
    rows = table(whole, "numbers", "source", "effect", "parameter")
    drag = rows.loc[("arena", "drag", "cd")]
    assert drag[["original", "amended", "truth"]].tolist() == [0.4, 0.54, 0.54]
    assert drag["low"] < 0.54 < drag["high"]
    assert np.isnan(rows.loc[("arena", "wind", "x"), "truth"])


def test_a_source_that_amended_nothing_is_named(whole):
    settings = RetrainPolicySettings(sources=["lab"])
    run = StageRun("retrain_policy", whole.root, params(retrain_policy=settings), "f" * 64)
    with pytest.raises(InputError, match="has not amended imperfect_c from shots of lab"):
        retrain_policy(run)
