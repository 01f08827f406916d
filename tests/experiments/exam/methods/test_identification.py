"""Identification, against closed forms of statistics."""

import numpy as np
import pytest

from experiments.exam.methods.identification import jackknife, separable
from experiments.exam.methods.regression import Regression
from rallygap.models.gap.hypotheses import Hypothesis
from tests.experiments.exam.example_trials import NOMINAL


def test_the_error_of_a_mean_is_the_one_of_the_textbook_and_no_smaller_than_the_noise():
    values = 3.0 * np.random.default_rng(0).standard_normal(30)
    rows = np.stack([np.ones(30), values], axis=1)
    grams = rows[:, :, None] * rows[:, None, :]
    mean, error = jackknife(grams)
    assert mean == pytest.approx([values.mean()])
    assert error == pytest.approx([values.std(ddof=1) / np.sqrt(30)])
    # Fully correlated samples are no more evidence than one.
    assert jackknife(50 * grams)[1] == pytest.approx(error)
    equal = np.array([[1.0, 0.7], [0.7, 0.49]])
    assert jackknife(np.tile(equal, (30, 1, 1)))[1] == pytest.approx([1 / np.sqrt(30)])


def test_of_parallel_columns_the_simulators_own_is_fitted():
    columns = (Hypothesis("drag", "cd"), Hypothesis("linear_drag", "k1"), Hypothesis("wind", "x"))
    first, second, third, noise = np.random.default_rng(0).standard_normal((4, 20, 40))
    rows = np.stack([first, 3 * first + 0.5 * third, 0.5 * second, noise], axis=2)
    classes = tuple((one,) for one in columns)
    regression = Regression(columns, np.swapaxes(rows, 1, 2) @ rows, classes)
    assert sorted(separable(regression, NOMINAL)) == [0, 2]
