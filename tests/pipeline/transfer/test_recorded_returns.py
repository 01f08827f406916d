"""Films of replayed balls show what was played, and what was told when."""

import numpy as np
import pandas as pd
import pytest

from models.ball.simulators import shipped
from models.policy.goals import draw_goals
from models.policy.incoming_balls import FIRST_WINDOW, TICK
from models.predictors.physics import PhysicsPredictor
from models.robot.kinematics import racket
from pipeline.transfer.example_returns import read_returns, write_returns
from pipeline.transfer.recorded_returns import chosen, filmed
from pipeline.transfer.replay_sets import read_replay_sets
from pipeline.transfer.replay_trials import EveryTick, replays
from tests.pipeline.played_trials import trials
from tests.pipeline.replayed import LAUNCH, SETTINGS, launched, write_replays
from tests.pipeline.trained_policies import chaser, description

TELLERS = [
    EveryTick("physics", PhysicsPredictor(shipped("imperfect_c"))),
    EveryTick("oracle", PhysicsPredictor(shipped("literature"))),
]
BALL = 1


@pytest.fixture(scope="module")
def replayed(tmp_path_factory):
    """A set of two balls, a policy that hits them, and its goals."""
    states = LAUNCH + np.array([[0.0], [0.01]])
    root = tmp_path_factory.mktemp("replayed")
    folder = write_replays(root, sources=("plain",), launches=launched(*states))
    shots = read_replay_sets(folder, SETTINGS, 0)[-1]
    trained = description()
    return shots, (chaser(), trained), draw_goals(trained.goals, 2, np.random.default_rng(0))


@pytest.fixture(scope="module")
def films(replayed):
    shots, player, goals = replayed
    return filmed(shots, BALL, goals, player, TELLERS)


def at(track, time):
    """Where something was at a time (s), between two samples of its track."""
    return np.array([np.interp(time, track.t, axis) for axis in np.array(track.position).T])


def test_one_film_for_each_that_tells(films):
    assert [one.told_by for one in films] == ["physics", "oracle"]
    assert {one.name for one in films} == {"thrown 1"}
    assert all(set(one.forecasts) == {"physics", "oracle"} for one in films)


def test_the_film_ends_as_the_trial_did(replayed, films):
    shots, player, goals = replayed
    for one, trial in zip(films, replays(shots, TELLERS, [player], seed=0), strict=True):
        trial.goals.landing[:] = goals.landing
        played = trial.results().iloc[BALL]
        assert one.hit == pytest.approx(played["time"], abs=1e-6)
        assert one.outcome == (played["fault"] or "returned")


def test_the_racket_is_at_the_ball_when_it_hits(films):
    for one in films:
        joints = np.array(one.joints)
        times = one.frame * np.arange(len(joints))
        pose = [[np.interp(one.hit, times, column) for column in joints.T]]
        centre = racket(pose, np.zeros((1, 6))).position[0]
        assert np.linalg.norm(at(one.ball, one.hit) - centre) < 0.11


def test_the_ball_comes_on_its_true_path_and_turns_at_the_hit(replayed, films):
    path = replayed[0].path[BALL]
    for one in films:
        times, places = np.array(one.ball.t), np.array(one.ball.position)
        before = times < one.hit
        steps = np.rint(1000 * times[before]).astype(int)
        assert places[before] == pytest.approx(path[steps, :3], abs=1e-4)
        assert one.hit in one.ball.t
        assert np.diff(places[before, 1])[-1] < 0 < np.diff(places[~before, 1])[0]


def test_forecasts_are_those_of_the_ticks_before_the_hit(films):
    for one in films:
        for told in one.forecasts.values():
            ticks = [forecast.at for forecast in told]
            assert ticks == pytest.approx(FIRST_WINDOW + TICK * np.arange(len(ticks)))
            assert ticks[-1] <= one.hit < ticks[-1] + TICK


def test_the_physics_that_flew_the_ball_tells_best(films):
    ball, ahead = films[0].ball, films[0].horizon
    off = {}
    for name, told in films[0].forecasts.items():
        soon = [(one.track, one.at + ahead) for one in told if one.at + ahead < films[0].hit]
        apart = [at(track, time) - at(ball, time) for track, time in soon]
        off[name] = np.linalg.norm(apart, axis=1).mean()
    assert off["oracle"] < off["physics"]


def test_returns_are_read_as_they_were_written(tmp_path, films):
    write_returns(tmp_path / "returns.json", films)
    assert read_returns(tmp_path / "returns.json") == films


def test_balls_that_end_differently_are_chosen_first_then_those_always_returned():
    played = pd.concat([
        trials([0, 1, 1, 0, 0], predictor="physics"),
        trials([0, 1, 0, 0, 1], predictor="transformer"),
    ])  # fmt: skip
    assert chosen(played, ["physics", "transformer"], 4) == [2, 4, 1, 0]
    assert chosen(played, ["physics"], 2) == [1, 2]
