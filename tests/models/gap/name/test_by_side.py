"""By side: a draught in half of the room is found with its size, and is no error of the cameras."""

import pytest

from rallygap.models.exam.interface import shots_of
from rallygap.models.exam.simulate.recordings import simulate_trial
from rallygap.models.exam.simulate.trial import Trial
from rallygap.models.exam.simulate.varying import Variation
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.naming import name
from rallygap.models.gap.name.variation import variations
from rallygap.models.gap.settings import Question
from tests.models.gap.hidden import NOMINAL, SETTINGS

WIND = Hypothesis("wind", "x")
DRAG = Hypothesis("drag", "cd")


def named(hidden, value, by_side=True):
    """Name the causes of 60 shots of which one parameter has another value where y > 0."""
    trial = Trial(
        "",
        NOMINAL,
        causes={hidden.effect: {hidden.parameter: value}},
        variation=Variation("place", hidden) if by_side else None,
        shots=60,
        seed=5,
    )
    recordings, _ = simulate_trial(trial)
    return name(shots_of(recordings), Question(NOMINAL, SETTINGS))


@pytest.mark.parametrize(("hidden", "value"), [(WIND, 0.3), (DRAG, 0.6)])
def test_an_effect_in_half_of_the_room_is_found_with_its_size(hidden, value):
    found = named(hidden, value)
    (variation,) = variations(found)
    difference = value - hidden.value(NOMINAL)
    assert (variation.identity, variation.kind) == (hidden.identity, "by_side")
    assert variation.size == pytest.approx(difference, rel=0.3)
    assert variation.interval[0] < difference < variation.interval[1]
    assert found.distortion is None
    causes = [found.explainer.evidence.columns[k] for k in found.explanation.causes]
    assert hidden in causes


def test_an_effect_in_the_whole_room_is_no_difference():
    assert variations(named(WIND, 0.3, by_side=False)) == ()
