"""Regressions: observable columns, classes of parallel ones, and answers."""

import numpy as np
import pytest

from experiments.exam.methods.regression import Regression, answer, candidates
from rallygap.models.gap.hypotheses import Hypothesis
from tests.experiments.exam.example_trials import NOMINAL

COLUMNS = (
    Hypothesis("gravity", "g"),
    Hypothesis("table_bounce", "restitution"),
    Hypothesis("buoyancy", "b"),
    Hypothesis("wind", "x"),
    Hypothesis("net", "restitution"),
)


def regression(slopes=(0.03, 0.2), shots=20):
    """Gravity and buoyancy have one signature, and nothing shows the net."""
    random = np.random.default_rng(0)
    pull, bounce, air, noise = random.standard_normal((4, shots, 30))
    residual = slopes[0] * 100 * pull + slopes[1] * 100 * air + noise
    columns = [100 * pull, 100 * bounce, -14 * pull + 0.1 * noise, 100 * air, 0 * air, residual]
    rows = np.stack(columns, axis=2)
    return Regression.of(COLUMNS, np.swapaxes(rows, 1, 2) @ rows)


def test_parallel_columns_are_one_class_and_unobservable_ones_none():
    found = regression()
    assert found.columns == (COLUMNS[0], COLUMNS[1], COLUMNS[3])
    assert found.classes[0] == (COLUMNS[0], COLUMNS[2])


def test_an_answer_names_what_explains_most_first_and_amends_it():
    found = answer(NOMINAL, regression(), (0, 2), np.array([0.03, 0.2]))
    assert found.conclusion == "ambiguous"
    assert [cause.identity for cause in found.causes] == ["wind.x", "gravity.g"]
    assert found.causes[1].possible == ("gravity.g", "buoyancy.b")
    assert found.amended.effects["wind"]["x"] == 0.2
    assert found.amended.effects["gravity"]["g"] == pytest.approx(9.84)


def test_an_estimate_stays_within_bounds():
    span = np.array([[0.1, 0.3]])
    found = answer(NOMINAL, regression(), (1,), np.array([0.2]), span)
    (cause,) = found.causes
    assert (found.conclusion, cause.identity) == ("named", "table_bounce.restitution")
    assert cause.estimate == 1.0
    assert cause.interval == pytest.approx((1.03, 1.23))


def test_candidates_are_what_balls_can_show_without_what_is_withheld():
    names = [one.effect for one in candidates(NOMINAL, ("wind",))]
    assert names[:3] == ["drag", "gravity", "magnus"]
    assert not {"wind", "time_offset", "net", "racket_bounce"} & set(names)
