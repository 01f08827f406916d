"""SINDy, on matrices with known sparse solutions and on recordings without noise."""

from functools import cache

import numpy as np
import pytest

from models.exam.interface import rounded
from models.exam.methods.regression import Regression
from models.exam.methods.sindy import bootstrap_weights, inclusion, sindy, sindy_ensemble, sparse
from models.exam.simulate.recordings import simulate_trial
from models.gap.hypotheses import Hypothesis
from tests.models.exam.example_trials import NOMINAL, ideal

METHODS = pytest.mark.parametrize("method", [sindy, sindy_ensemble])


@cache
def recorded(effect=None, parameter="", value=0.0, **settings):
    causes = {effect: {parameter: value}} if effect else {}
    return simulate_trial(ideal(shots=24, seed=1002, causes=causes, **settings))[0]


def rows(*coefficients, seed=0):
    """Terms of unit length, and a sum of them in unit noise."""
    random = np.random.default_rng(seed)
    terms = random.standard_normal((40, 50, len(coefficients)))
    scale = np.sqrt((terms**2).sum(axis=(0, 1)))
    noise = random.standard_normal((40, 50))
    return np.concatenate([terms, (terms / scale @ coefficients + noise)[..., None]], axis=2)


def gram(*coefficients):
    flat = rows(*coefficients).reshape(-1, len(coefficients) + 1)
    return flat.T @ flat


def test_terms_above_the_threshold_are_kept_whatever_their_scale():
    table = gram(20.0, 0.0, -12.0, 3.0, 0.0)
    scale = np.diag([1e-6, 1.0, 1e6, 1.0, 1.0, 1.0])
    assert sparse(scale @ table @ scale, 7.0) == (0, 2)
    assert sparse(table, 40.0) == ()


def test_an_ensemble_includes_what_most_of_its_models_do():
    table = rows(20.0, 0.0, 7.0)
    columns = tuple(Hypothesis("wind", axis) for axis in "xyz")
    regression = Regression.of(columns, np.swapaxes(table, 1, 2) @ table)
    included = inclusion(regression, bootstrap_weights(40), 7.0)
    assert included[0] == 1.0
    assert included[1] == 0.0
    assert 0.2 < included[2] < 0.8


def test_a_bag_has_as_many_shots_as_there_are():
    drawn = bootstrap_weights(30)
    assert (drawn.sum(axis=1) == 30).all()
    assert drawn.mean(axis=0) == pytest.approx(np.ones(30), abs=0.5)


@METHODS
def test_a_large_effect_in_flight_is_named_without_noise(method):
    found = method(recorded("wind", "x", 0.1), NOMINAL, ())
    assert (found.conclusion, [cause.identity for cause in found.causes]) == ("named", ["wind.x"])
    assert found.causes[0].estimate == pytest.approx(0.1, rel=0.03)
    assert rounded(found.amended.effects["wind"]["x"]) == found.causes[0].estimate


@METHODS
def test_nothing_is_named_without_noise_and_without_a_gap(method):
    assert method(recorded(), NOMINAL, ()).conclusion == "no_gap"


@pytest.mark.parametrize(
    ("effect", "parameter", "value"),
    [
        ("table_bounce", "restitution", 0.90),
        ("table_tilt", "y", 0.01),
        ("spin_axis_bias", "z", 0.2),
    ],
)
def test_effects_of_the_table_and_of_labels_are_named(effect, parameter, value):
    found = sindy(recorded(effect, parameter, value), NOMINAL, ())
    assert found.causes[0].identity == f"{effect}.{parameter}"
    assert found.causes[0].estimate == pytest.approx(value, rel=0.05)


def test_a_withheld_effect_is_never_named():
    found = sindy(recorded("wind", "x", 0.1), NOMINAL, ("wind",))
    assert found.conclusion != "no_gap"
    assert "wind.x" not in {name for cause in found.causes for name in cause.possible}


def test_shots_without_labels_are_used():
    found = sindy(recorded("table_tilt", "y", 0.01, spin_labels="none"), NOMINAL, ())
    assert found.causes[0].identity == "table_tilt.y"
