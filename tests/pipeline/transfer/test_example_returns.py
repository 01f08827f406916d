"""Example shots show what was played, and what was forecast when."""

import numpy as np
import pandas as pd
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.policy.incoming_balls import CONTROL_STEP, FIRST_WINDOW
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.robot.kinematics import racket
from rallygap.pipeline.transfer.example_returns import choose, example_returns
from rallygap.pipeline.transfer.replay_sets import read_replay_sets
from rallygap.pipeline.transfer.replay_trials import Forecaster, replay_trials
from rallygap.pipeline.transfer.returns import ONCE
from rallygap.pipeline.transfer.shown_returns import read_returns, write_returns
from tests.pipeline.replayed import LAUNCH, SETTINGS, launched, write_replays
from tests.pipeline.trained_policies import chaser, description

SIMULATOR = shipped("imperfect_c")
FORECASTERS = [
    Forecaster("physics", PhysicsPredictor(SIMULATOR), ONCE),
    Forecaster("physics", PhysicsPredictor(SIMULATOR)),
    Forecaster("oracle", PhysicsPredictor(shipped("literature"))),
]


@pytest.fixture(scope="module")
def trials(tmp_path_factory):
    """Trials of a set of two shots with a policy that hits them, and their results."""
    states = LAUNCH + np.array([[0.0], [0.01]])
    root = tmp_path_factory.mktemp("replayed")
    folder = write_replays(root, sources=("plain",), launches=launched(*states))
    shots = read_replay_sets(folder, SETTINGS, 0)[-1]
    policies = [(chaser(), description()), (chaser(3.0), description(repeat=1))]
    planned = replay_trials(shots, FORECASTERS, policies, 0, ["physics", "oracle"])
    return [(trial, trial.run()) for trial in planned]


@pytest.fixture(scope="module")
def examples(trials):
    return example_returns(trials, ["oracle"])


def test_every_shot_is_shown_with_both_predictors_as_it_ended(tmp_path, trials, examples):
    assert sorted((one.name, one.predictor) for one in examples) == [
        ("thrown 0", "oracle"), ("thrown 0", "physics"),
        ("thrown 1", "oracle"), ("thrown 1", "physics"),
    ]  # fmt: skip
    tables = {trial.forecaster.name: result.table for trial, result in trials[1:]}
    for one in examples:
        row = tables[one.predictor].query("repeat == 0").iloc[int(one.name[-1])]
        assert one.hit == pytest.approx(row["time"], abs=1e-6)
        assert one.outcome == (row["fault"] or "returned")
        assert set(one.forecasts) == {"physics", "oracle"}
    write_returns(tmp_path / "returns.json", examples)
    assert read_returns(tmp_path / "returns.json") == examples


def test_the_ball_comes_on_its_true_path_meets_the_racket_and_turns(trials, examples):
    for one in examples:
        path = trials[0][0].shots.path[int(one.name[-1])]
        times, places = np.array(one.ball.t), np.array(one.ball.position)
        before = times < one.hit
        steps = np.rint(1000 * times[before]).astype(int)
        assert places[before] == pytest.approx(path[steps, :3], abs=1e-4)
        assert np.diff(places[before, 1])[-1] < 0 < np.diff(places[~before, 1])[0]
        joints = np.array(one.joints)
        shown = one.frame * np.arange(len(joints))
        pose = [[np.interp(one.hit, shown, column) for column in joints.T]]
        centre = racket(pose, np.zeros((1, 6))).position[0]
        (met,) = places[times == one.hit]
        assert np.linalg.norm(met - centre) < 0.11


def test_forecasts_are_those_of_the_control_steps_before_the_hit(examples):
    for one in examples:
        for forecasts in one.forecasts.values():
            times = [forecast.at for forecast in forecasts]
            assert times == pytest.approx(FIRST_WINDOW + CONTROL_STEP * np.arange(len(times)))
            assert times[-1] <= one.hit < times[-1] + CONTROL_STEP


def test_shots_that_the_first_alone_returns_come_first_then_other_differences():
    returned = pd.DataFrame({"transformer": [0, 1, 0, 0, 1], "physics": [0, 1, 1, 0, 0]}) == 1
    assert choose(returned, 4) == [4, 2, 1, 0]
    assert choose(returned[["physics"]], 2) == [1, 2]
