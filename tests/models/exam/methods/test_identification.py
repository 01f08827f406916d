"""Identification, against closed forms of statistics and on recordings without noise."""

from functools import cache

import numpy as np
import pytest

from models.exam.methods.identification import identification, jackknife, separable
from models.exam.methods.regression import Regression
from models.exam.simulate.recordings import simulate_trial
from models.gap.hypotheses import Hypothesis
from tests.models.exam.example_trials import NOMINAL, ideal


@cache
def recorded(effect=None, parameter="", value=0.0):
    causes = {effect: {parameter: value}} if effect else {}
    return simulate_trial(ideal(shots=24, seed=1002, causes=causes))[0]


def test_the_error_of_a_mean_is_the_one_of_the_textbook():
    values = 3.0 * np.random.default_rng(0).standard_normal(30)
    rows = np.stack([np.ones(30), values], axis=1)
    mean, error = jackknife(rows[:, :, None] * rows[:, None, :])
    assert mean == pytest.approx([values.mean()])
    assert error == pytest.approx([values.std(ddof=1) / np.sqrt(30)])


def test_fully_correlated_samples_are_no_more_evidence_than_one():
    values = 3.0 * np.random.default_rng(0).standard_normal(30)
    rows = np.stack([np.ones(30), values], axis=1)
    alone = rows[:, :, None] * rows[:, None, :]
    assert jackknife(50 * alone)[1] == pytest.approx(jackknife(alone)[1])


def test_errors_are_no_smaller_than_those_of_the_noise():
    rows = np.stack([np.ones(30), np.full(30, 0.7)], axis=1)
    assert jackknife(rows[:, :, None] * rows[:, None, :])[1] == pytest.approx([1 / np.sqrt(30)])


def test_of_parallel_columns_the_simulators_own_is_fitted():
    columns = (Hypothesis("drag", "cd"), Hypothesis("linear_drag", "k1"), Hypothesis("wind", "x"))
    first, second, third, noise = np.random.default_rng(0).standard_normal((4, 20, 40))
    rows = np.stack([first, 3 * first + 0.5 * third, 0.5 * second, noise], axis=2)
    classes = tuple((one,) for one in columns)
    regression = Regression(columns, np.swapaxes(rows, 1, 2) @ rows, classes)
    assert sorted(separable(regression, NOMINAL)) == [0, 2]


def test_a_large_effect_in_flight_is_named_without_noise():
    found = identification(recorded("wind", "x", 0.5), NOMINAL, ())
    assert (found.conclusion, [cause.identity for cause in found.causes]) == ("named", ["wind.x"])
    cause = found.causes[0]
    assert cause.estimate == pytest.approx(0.5, rel=1e-3)
    assert cause.interval[0] <= cause.estimate <= cause.interval[1]


def test_a_wrong_parameter_of_the_table_is_named_without_noise():
    found = identification(recorded("table_bounce", "restitution", 0.90), NOMINAL, ())
    assert [cause.identity for cause in found.causes] == ["table_bounce.restitution"]
    assert found.amended.effects["table_bounce"]["restitution"] == pytest.approx(0.9, abs=1e-3)


def test_nothing_is_named_without_noise_and_without_a_gap():
    assert identification(recorded(), NOMINAL, ()).conclusion == "no_gap"


def test_a_withheld_effect_is_never_named():
    found = identification(recorded("wind", "x", 0.5), NOMINAL, ("wind",))
    assert "wind.x" not in {name for cause in found.causes for name in cause.possible}
