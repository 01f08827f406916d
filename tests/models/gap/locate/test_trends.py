"""Growth: the axis that matters comes first, and none is found by chance."""

import numpy as np
import pytest
from scipy.stats import f_oneway, ttest_1samp

from models.gap.locate.covariates import Axis
from models.gap.locate.trends import over_time, trends_against
from tests.models.gap.hidden import SETTINGS


def drawn(seed, count=40):
    """Partings of noise alone, and axes that have nothing to do with them."""
    random = np.random.default_rng(seed)
    axes = [Axis(f"axis {k}", "m", random.uniform(size=count)) for k in range(6)]
    return axes, random.normal(scale=(0.001, 0.002, 0.004), size=(count, 3))


def test_the_axis_that_matters_comes_first_with_its_means():
    axes, discrepancies = drawn(0, count=60)
    discrepancies[:, 1] += 0.01 * axes[3].values
    most, *others = trends_against(axes, discrepancies, settings=SETTINGS.locate)
    assert (most.covariate, most.unit) == ("axis 3", "m")
    assert most.p_value < 0.001 < min(one.p_value for one in others)
    expected = 0.01 * most.centres
    assert np.all(np.abs(most.means[:, 1] - expected) < 1.5 * most.errors[:, 1])
    assert most.counts.sum() == 60


def test_the_largest_of_many_axes_is_as_rare_as_its_chance_says():
    smallest = np.array(
        [trends_against(*drawn(seed), settings=SETTINGS.locate)[0].p_value for seed in range(20)]
    )
    assert (smallest < 0.05).sum() <= 4
    assert 0.3 < smallest.mean() < 0.7


def test_means_and_chance_are_those_of_an_analysis_of_variance():
    """Of kinds of which there are few, more and many, and partings along the course alone."""
    kinds = np.repeat([0.0, 1.0, 2.0], [6, 14, 40])
    discrepancies = np.zeros((60, 3))
    discrepancies[:, 0] = np.random.default_rng(4).normal(size=60) + 0.5 * (kinds == 0)
    (found,) = trends_against(
        [Axis("kind", "", kinds, ("few", "more", "many"))], discrepancies, settings=SETTINGS.locate
    )
    groups = [discrepancies[kinds == kind, 0] for kind in range(3)]
    ends = [ttest_1samp(group, 0.0).confidence_interval() for group in groups]
    np.testing.assert_allclose(found.means[:, 0] - found.errors[:, 0], [one.low for one in ends])
    np.testing.assert_allclose(found.means[:, 0] + found.errors[:, 0], [one.high for one in ends])
    assert found.p_value == pytest.approx(f_oneway(*groups).pvalue, abs=0.03)


def test_the_share_is_that_of_the_variance_between_bins():
    values = np.repeat([0.0, 1.0], 50)
    discrepancies = np.zeros((100, 3))
    discrepancies[:, 2] = 0.01 * values + np.tile([-0.005, 0.005], 50)
    found = trends_against(
        [Axis("side", "", values, ("left", "right"))], discrepancies, settings=SETTINGS.locate
    )[0]
    assert found.share == pytest.approx(0.5, abs=0.01)
    assert found.kinds == ("left", "right")
    np.testing.assert_allclose(found.means[:, 2], [0.0, 0.01], atol=1e-12)


def test_shots_without_a_value_and_axes_without_a_difference_are_left_out():
    axes, discrepancies = drawn(1)
    some = Axis("some", "m", np.where(np.arange(40) < 20, axes[0].values, np.nan))
    same = Axis("same", "", np.zeros(40), ("all", "none"))
    discrepancies[0] = np.nan
    (found,) = trends_against([some, same], discrepancies, settings=SETTINGS.locate)
    assert (found.covariate, found.counts.sum()) == ("some", 19)


def test_three_shots_are_no_bin_and_four_are():
    kinds = np.repeat([0.0, 1.0, 2.0], [33, 4, 3])
    (found,) = trends_against(
        [Axis("kind", "", kinds, ("many", "few", "fewer"))], drawn(3)[1], settings=SETTINGS.locate
    )
    assert (found.kinds, found.counts.tolist()) == (("many", "few"), [33, 4])


def test_what_all_shots_have_in_common_shows_over_time():
    _, noise = drawn(2)
    horizons = np.array([0.1, 0.2, 0.3])
    discrepancies = noise[:, None] * np.ones((1, 3, 1))
    assert over_time(horizons, discrepancies, settings=SETTINGS.locate).p_value > 0.05
    discrepancies[..., 0] -= 0.02 * horizons
    discrepancies[:30, 2] = np.nan
    found = over_time(horizons, discrepancies, settings=SETTINGS.locate)
    assert found.p_value < 0.001
    assert found.counts.tolist() == [40, 40, 10]
    assert found.means[1, 0] == pytest.approx(-0.004 + noise[:, 0].mean())
