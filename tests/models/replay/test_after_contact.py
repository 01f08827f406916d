"""Struck: the strokes of a trial, once more, to the last bit."""

import numpy as np

from models.ball.simulators import shipped
from models.policy.outcome import topspin
from models.policy.task import Task
from models.policy.trial import ARMS, play
from models.replay.after_contact import struck
from tests.models.policy.schooling import GOALS
from tests.pipeline.trained_policies import chaser


def test_what_leaves_the_racket_is_what_the_trial_saw():
    simulator, count = shipped("imperfect_c"), ARMS + 3
    task = Task(simulator, (115, 120, 125), GOALS, "intercept")
    balls, goals = task.practice(count, np.random.default_rng(0))
    played = play(chaser(), simulator, balls, goals, "intercept")

    after = struck(chaser(), simulator, balls, goals, "intercept")

    hit = played["hit"].to_numpy()
    assert hit.any() and (np.isfinite(after).all(axis=1) == hit).all()
    speeds = np.linalg.norm(after[hit, 3:6], axis=1)
    assert (speeds == played.loc[hit, "speed"]).all()
    assert (topspin(after[hit]) == played.loc[hit, "topspin"]).all()
