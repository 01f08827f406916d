"""Trials run on all cores; each is labelled with its policy and its forecast error."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from rallygap.models.policy.trial import play
from rallygap.pipeline.transfer.trials import play_policy
from tests.models.policy.schooling import drawn_policy
from tests.pipeline.trained_policies import chaser, description


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


def test_a_policy_observes_how_sure_its_predictor_is():
    trained = description(observation="spread", forecasts="filtered")
    policy, task = drawn_policy(0, kind="spread"), trained.task
    balls, goals = task.draw(6, np.random.default_rng(0))
    surer = replace(balls, spreads=0.1 * balls.spreads)
    tables = [
        play_policy(policy, trained, task.simulator, one, goals).table for one in (balls, surer)
    ]
    assert (tables[0]["nearest"] != tables[1]["nearest"]).any()
