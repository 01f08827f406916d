"""Settings that are refused; goals and random streams that are drawn as set."""

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from rallygap.models.policy.goals import draw_goals
from rallygap.models.policy.random_streams import (
    evaluation_stream,
    iteration_seed,
    validation_stream,
)
from rallygap.models.policy.settings import GoalSettings, HorizonsMs

GOALS = {"landing_across": (-0.4, 0.4), "landing_along": (0.5, 1.1), "speed": None, "topspin": None}


@pytest.mark.parametrize(
    "horizons", [(120, 115, 125), (115, 115, 120), (117, 120, 125), (0, 5, 10), (295, 300, 305)]
)
def test_horizons_that_no_predictor_gives_are_refused(horizons):
    with pytest.raises(ValidationError):
        TypeAdapter(HorizonsMs).validate_python(horizons)


@pytest.mark.parametrize(
    "wrong",
    [{"landing_along": (-0.5, 1.1)}, {"landing_across": (-0.4, 0.9)}, {"speed": (6.0, 4.0)}],
)
def test_goals_off_the_far_half_or_the_wrong_way_round_are_refused(wrong):
    with pytest.raises(ValidationError, match=next(iter(wrong))):
        GoalSettings(**{**GOALS, **wrong})


def test_goals_fill_their_limits_evenly():
    settings = GoalSettings(**{**GOALS, "speed": (4.0, 7.0), "topspin": (-100.0, 100.0)})
    goals = draw_goals(settings, 2000, np.random.default_rng(0))
    both = [*goals.landing.T, goals.speed, goals.topspin]
    limits = [settings.landing_across, settings.landing_along, settings.speed, settings.topspin]
    for values, (low, high) in zip(both, limits, strict=True):
        assert (low <= values).all() and (values <= high).all()
        quarters = np.histogram(values, bins=4, range=(low, high))[0]
        np.testing.assert_allclose(quarters, 500, atol=90)  # 4.6 standard deviations


def test_no_two_uses_of_a_seed_share_their_numbers():
    sources = [np.random.default_rng(iteration_seed(3, iteration)) for iteration in range(4)]
    sources += [validation_stream(3), evaluation_stream(3), np.random.default_rng(3)]
    assert len({source.random() for source in sources}) == len(sources)
