"""Trends: the true covariate comes first, and none is found by chance."""

import numpy as np
import pytest
from scipy.stats import f_oneway, ttest_1samp

from rallygap.models.gap.locate.covariates import Axis
from rallygap.models.gap.locate.trends import trends_against
from tests.models.gap.hidden import SETTINGS


def drawn(seed, count=40):
    """Discrepancies of noise alone, and unrelated covariates."""
    random = np.random.default_rng(seed)
    axes = [Axis(f"axis {k}", "m", random.uniform(size=count)) for k in range(6)]
    return axes, random.normal(scale=(0.001, 0.002, 0.004), size=(count, 3))


def test_the_true_covariate_comes_first_with_its_means():
    axes, discrepancies = drawn(0, count=60)
    discrepancies[:, 1] += 0.01 * axes[3].values
    most, *others = trends_against(axes, discrepancies, SETTINGS.locate)
    assert (most.covariate, most.unit) == ("axis 3", "m")
    assert most.p_value < 0.001 < min(one.p_value for one in others)
    expected = 0.01 * most.centres
    assert np.all(np.abs(most.means[:, 1] - expected) < 1.5 * most.margins[:, 1])
    # P-values are adjusted for the number of covariates.
    smallest = [trends_against(*drawn(seed), SETTINGS.locate)[0].p_value for seed in range(12)]
    assert sum(p_value < 0.05 for p_value in smallest) <= 3


def test_means_and_p_value_are_those_of_an_analysis_of_variance():
    kinds = np.repeat([0.0, 1.0, 2.0], [6, 14, 40])
    discrepancies = np.zeros((60, 3))
    discrepancies[:, 0] = np.random.default_rng(4).normal(size=60) + 0.5 * (kinds == 0)
    (found,) = trends_against(
        [Axis("kind", "", kinds, ("few", "more", "many"))], discrepancies, SETTINGS.locate
    )
    groups = [discrepancies[kinds == kind, 0] for kind in range(3)]
    ends = [ttest_1samp(group, 0.0).confidence_interval() for group in groups]
    np.testing.assert_allclose(found.means[:, 0] - found.margins[:, 0], [one.low for one in ends])
    np.testing.assert_allclose(found.means[:, 0] + found.margins[:, 0], [one.high for one in ends])
    assert found.p_value == pytest.approx(f_oneway(*groups).pvalue, abs=0.03)


def test_the_share_is_that_of_the_variance_between_bins():
    values, discrepancies = np.repeat([0.0, 1.0], 50), np.zeros((100, 3))
    discrepancies[:, 2] = 0.01 * values + np.tile([-0.005, 0.005], 50)
    sides = Axis("side", "", values, ("left", "right"))
    (found,) = trends_against([sides], discrepancies, SETTINGS.locate)
    assert found.share == pytest.approx(0.5, abs=0.01)
    assert found.kinds == ("left", "right")
    np.testing.assert_allclose(found.means[:, 2], [0.0, 0.01], atol=1e-12)


def test_missing_values_constant_covariates_and_small_bins_are_left_out():
    axes, discrepancies = drawn(1)
    some = Axis("some", "m", np.where(np.arange(40) < 20, axes[0].values, np.nan))
    same = Axis("same", "", np.zeros(40), ("all", "none"))
    discrepancies[0] = np.nan
    (found,) = trends_against([some, same], discrepancies, SETTINGS.locate)
    assert found.covariate == "some"
    kinds = Axis("kind", "", np.repeat([0.0, 1.0, 2.0], [33, 4, 3]), ("many", "few", "fewer"))
    (found,) = trends_against([kinds], drawn(3)[1], SETTINGS.locate)
    assert found.kinds == ("many", "few")
