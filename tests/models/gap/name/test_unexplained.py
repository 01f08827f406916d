"""Unexplained structure: what the catalogue does not explain is found, and only that."""

import re

import numpy as np
import pytest

from rallygap.models.gap.fit.refit import refit
from rallygap.models.gap.name.unexplained import find_unexplained, formula
from rallygap.models.gap.settings import Question
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

TILTED = NOMINAL.amended("table_tilt", x=0.01)
WITHOUT_TILT = Question(NOMINAL, withheld=("table_tilt",))


def fitted(truth, seed, count=16):
    return refit(measured(truth, count=count, seed=seed), NOMINAL, (), SETTINGS.fit)


@pytest.fixture(scope="module")
def tilted():
    return fitted(TILTED, 1)


def test_an_effect_that_is_not_in_the_catalogue_is_unexplained(tilted):
    left = find_unexplained(tilted, WITHOUT_TILT)
    assert left.p_value < 0.003
    assert left.phase in ("table", "sensor")
    assert " x]" in left.candidate_formula


def test_the_catalogue_explains_its_effects_and_three_shots(tilted):
    for one in (tilted, fitted(NOMINAL, 0, count=3)):
        assert find_unexplained(one, Question(NOMINAL)).p_value > 0.003


@pytest.mark.slow
def test_only_shots_with_the_effect_confirm_it(tilted):
    level = fitted(NOMINAL, 2)
    assert find_unexplained(level, WITHOUT_TILT).p_value > 0.003
    left = find_unexplained(tilted, WITHOUT_TILT)
    assert left.confirmed(fitted(TILTED, 3))
    assert not left.confirmed(level)


def test_the_formula_has_the_true_terms_with_their_sizes():
    random = np.random.default_rng(0)
    rows = random.standard_normal((40, 6)) * [1.0, 10.0, 1.0, 5.0, 1.0, 2.0]
    target = rows @ [0.0, 2.0, 0.0, -3.0, 0.0, 0.0] + random.standard_normal(40)
    terms = re.findall(
        r"([+-][\d.e+-]+) \[(\w)\]", formula(list("abcdef"), rows, target, SETTINGS.name)
    )
    assert [name for _, name in terms] == ["b", "d"]
    assert np.allclose([float(value) for value, _ in terms], [2.0, -3.0], rtol=0.15)
