"""Trials are played on all cores, and each tells who played and how far it was misled."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import pytest

from models.policy.trial import play
from pipeline.transfer.trials import play_all, try_policy
from tests.pipeline.trained_policies import chaser, description


@dataclass(frozen=True)
class Counted:
    """A trial that tells its number, once a ball."""

    number: int

    def results(self):
        return pd.DataFrame({"number": [self.number] * (self.number % 3)})


def test_results_come_in_the_order_of_the_trials():
    found = play_all([Counted(number) for number in (5, 3, 1, 4)])
    assert found["number"].tolist() == [5, 5, 1, 4]
    assert found.index.tolist() == [0, 1, 2, 3]


def test_a_trial_tells_what_play_does_who_played_and_how_far_off_forecasts_were():
    trained, policy = description(repeat=2, horizons=(170, 175, 180)), chaser()
    task = trained.task
    balls, goals = task.practice(6, np.random.default_rng(0))
    told = replace(balls, forecasts=balls.forecasts + 0.02 * np.eye(9)[0])
    found = try_policy(policy, trained, task.simulator, told, goals)
    pd.testing.assert_frame_equal(
        found.iloc[:, :-4], play(policy, task.simulator, told, goals, "intercept")
    )
    assert found["ball"].tolist() == list(range(6))
    assert set(found["horizons_ms"]) == {"170-180"} and set(found["repeat"]) == {2}
    assert found["forecast_error_m"].tolist() == pytest.approx([0.02] * 6)
