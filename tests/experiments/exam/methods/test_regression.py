"""Regressions: terms, classes and answers, against equations of motion and closed forms."""

import numpy as np
import pytest

from experiments.exam.methods.derivatives import library, rates
from experiments.exam.methods.identification import jackknife, separable
from experiments.exam.methods.regression import Regression, answer
from experiments.exam.methods.sindy import inclusion, sparse
from rallygap.models.ball.state import DRAG_FACTOR, MAGNUS_FACTOR, SPIN, VELOCITY
from rallygap.models.gap.hypotheses import Hypothesis
from tests.experiments.exam.example_trials import NOMINAL

COLUMNS = (
    Hypothesis("gravity", "g"),
    Hypothesis("table_bounce", "restitution"),
    Hypothesis("buoyancy", "b"),
    Hypothesis("wind", "x"),
    Hypothesis("net", "restitution"),
)


def grams(rows):
    return np.swapaxes(rows, 1, 2) @ rows


def regression():
    """Gravity and buoyancy have one signature, and nothing shows the net."""
    random = np.random.default_rng(0)
    pull, bounce, air, noise = random.standard_normal((4, 20, 30))
    residual = 3 * pull + 20 * air + noise
    columns = [100 * pull, 100 * bounce, -14 * pull + 0.1 * noise, 100 * air, 0 * air, residual]
    return Regression.of(COLUMNS, grams(np.stack(columns, axis=2)))


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
    found = answer(NOMINAL, regression(), (1,), np.array([0.2]), np.array([[0.1, 0.3]]))
    (cause,) = found.causes
    assert (found.conclusion, cause.identity) == ("named", "table_bounce.restitution")
    assert cause.estimate == 1.0
    assert cause.interval == pytest.approx((1.03, 1.23))


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
    found = Regression(columns, grams(rows), tuple((one,) for one in columns))
    assert sorted(separable(found, NOMINAL)) == [0, 2]


def rows(*coefficients):
    """Terms of unit length, and a sum of them in unit noise."""
    random = np.random.default_rng(0)
    terms = random.standard_normal((40, 50, len(coefficients)))
    scale = np.sqrt((terms**2).sum(axis=(0, 1)))
    noise = random.standard_normal((40, 50))
    return np.concatenate([terms, (terms / scale @ coefficients + noise)[..., None]], axis=2)


def test_terms_above_the_threshold_are_kept_whatever_their_scale():
    table = grams(rows(20.0, 0.0, -12.0, 3.0, 0.0)).sum(axis=0)
    scale = np.diag([1e-6, 1.0, 1e6, 1.0, 1.0, 1.0])
    assert sparse(scale @ table @ scale, 7.0) == (0, 2)
    assert sparse(table, 40.0) == ()


def test_an_ensemble_includes_what_most_of_its_models_do():
    columns = tuple(Hypothesis("wind", axis) for axis in "xyz")
    found = Regression.of(columns, grams(rows(20.0, 0.0, 7.0)))
    weights = np.random.default_rng(0).multinomial(40, np.full(40, 1 / 40), 100)
    included = inclusion(found, weights.astype(float), 7.0)
    assert included[:2].tolist() == [1.0, 0.0]
    assert 0.2 < included[2] < 0.8


STATES = np.array([[0.1, -1.0, 0.5, 0.8, 6.0, 1.5, 150.0, -80.0, 40.0]])
FREE = NOMINAL.without_surfaces()
V, W = STATES[0, VELOCITY], STATES[0, SPIN]
LIFT = MAGNUS_FACTOR * 0.069 * np.cross(W, V)
DRAG = -DRAG_FACTOR * 0.54 * np.linalg.norm(V) * V


def term(effect, parameter):
    return library(FREE, STATES, 0.0, (Hypothesis(effect, parameter),)).terms[0, :, 0]


def test_rates_are_those_of_the_equations_of_motion():
    expected = np.concatenate([LIFT + DRAG + [0.0, 0.0, -9.81], np.zeros(3)])
    assert rates(FREE, STATES)[0] == pytest.approx(expected, abs=1e-3)


def test_parameters_change_rates_by_their_forces():
    assert term("drag", "cd")[:3] == pytest.approx(DRAG / 0.54, rel=1e-3)
    assert term("gravity", "g")[:3] == pytest.approx([0.0, 0.0, -1.0], abs=1e-4)
    decay = np.concatenate([np.zeros(3), -np.linalg.norm(V) * W])
    assert term("spin_decay", "c") == pytest.approx(decay, rel=1e-3, abs=1e-2)
    # Labels that read high look like too little lift.
    assert term("spin_gain", "s")[:3] == pytest.approx(-LIFT, rel=1e-3)


def test_a_slow_clock_changes_accelerations_and_what_speeds_explain_of_them():
    # a_m = a(v) / (1 + d)^2 and v = (1 + d) v_m: -2 a, plus 2 of drag and 1 of lift.
    expected = -2 * np.array([0.0, 0.0, -9.81]) - LIFT
    assert term("clock_rate", "d")[:3] == pytest.approx(expected, rel=1e-3, abs=2e-3)


def test_a_height_raises_a_ball_after_its_bounce_by_what_it_gains_both_ways():
    falling = np.array([[0.0, 0.8, 0.035, 0.0, 4.0, -3.0, 0.0, 0.0, 0.0]])
    found = library(NOMINAL, falling, 0.01, (Hypothesis("table_height", "h"),))
    assert np.isfinite(found.contacts).sum() == 1
    # Less what gravity does to it in the few milliseconds around.
    assert found.terms[0, 2, 0] == pytest.approx(1.93, abs=0.04)
