"""Trials run on all cores; each is labelled with its policy and its forecast error."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import pytest

from models.policy.trial import play
from pipeline.transfer.trials import Played, joined, play_policy, run_trials
from tests.pipeline.trained_policies import chaser, description


@dataclass(frozen=True)
class Numbered:
    """A trial whose table has its number in each of some rows."""

    number: int

    def run(self):
        return Played(pd.DataFrame({"number": [self.number] * (self.number % 3)}))


def test_results_come_in_the_order_of_the_trials():
    table = joined(run_trials([Numbered(number) for number in (5, 3, 1, 4)]))
    assert table["number"].tolist() == [5, 5, 1, 4]
    assert table.index.tolist() == [0, 1, 2, 3]


def test_trials_have_the_policy_s_labels_and_the_forecast_error():
    trained, policy = description(repeat=2, horizons=(170, 175, 180)), chaser()
    task = trained.task
    balls, goals = task.draw(6, np.random.default_rng(0))
    shifted = replace(balls, forecasts=balls.forecasts + 0.02 * np.eye(9)[0])
    table = play_policy(policy, trained, task.simulator, shifted, goals).table
    expected = play(policy, task.simulator, shifted, goals, "intercept").table
    pd.testing.assert_frame_equal(table.iloc[:, :-4], expected)
    assert table["ball"].tolist() == list(range(6))
    assert set(table["horizons_ms"]) == {"170-180"} and set(table["repeat"]) == {2}
    assert table["forecast_error_m"].tolist() == pytest.approx([0.02] * 6)
