"""Unknown: what the catalogue explains is not, and what it does not explain is found."""

import pytest

from models.gap.fit.refit import refit
from models.gap.name.unexplained import find_unexplained
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

TILTED = NOMINAL.amended("table_tilt", x=0.01)
TILT = ("table_tilt",)


def fit_nuisance(hall, seed):
    return refit(measured(hall, count=16, seed=seed), NOMINAL, (), settings=SETTINGS.fit)


@pytest.fixture(scope="module")
def tilted():
    return fit_nuisance(TILTED, 1)


@pytest.fixture(scope="module")
def level():
    return fit_nuisance(NOMINAL, 2)


def test_an_effect_that_is_not_in_the_catalogue_is_left_over(tilted):
    left = find_unexplained(tilted, SETTINGS, TILT)
    assert left.p_value < 0.003
    assert left.where in ("table", "sensor")
    assert " x]" in left.candidate_formula


def test_an_effect_of_the_catalogue_is_not_left_over(tilted):
    assert find_unexplained(tilted, settings=SETTINGS).p_value > 0.003


def test_what_three_shots_show_the_catalogue_explains():
    assert (
        find_unexplained(
            refit(measured(count=3), NOMINAL, (), settings=SETTINGS.fit), settings=SETTINGS
        ).p_value
        > 0.003
    )


@pytest.mark.slow
def test_nothing_is_left_over_where_nothing_is_wrong(level):
    assert find_unexplained(level, SETTINGS, TILT).p_value > 0.003


@pytest.mark.slow
def test_other_shots_confirm_what_they_show_as_well(tilted, level):
    left = find_unexplained(tilted, SETTINGS, TILT)
    assert left.confirmed(fit_nuisance(TILTED, 3))
    assert not left.confirmed(level)
