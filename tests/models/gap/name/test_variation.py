"""Variation: a parameter that drifts, or differs between shots or sides, is found alone."""

import pytest

from experiments.exam.interface import shots_of
from experiments.exam.simulate.recordings import simulate_trial
from experiments.exam.simulate.trial import Trial, Variation
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.naming import name
from rallygap.models.gap.name.variation import variations
from rallygap.models.gap.settings import Question
from tests.models.gap.hidden import NOMINAL, SETTINGS

DRAG, WIND = Hypothesis("drag", "cd"), Hypothesis("wind", "x")


def named(hypothesis, value, variation=None):
    causes = {hypothesis.effect: {hypothesis.parameter: value}}
    trial = Trial("", NOMINAL, causes=causes, variation=variation, shots=60, seed=5)
    return name(shots_of(simulate_trial(trial)[0]), Question(NOMINAL, SETTINGS))


@pytest.mark.parametrize(
    ("value", "variation", "kind", "size", "error"),
    [
        (0.55, Variation("drift", DRAG), "drift", 0.1, 0.2),
        (0.5, Variation("shot", DRAG, spread=0.1), "between_shots", 0.045, 0.3),  # of these draws
        (0.3, Variation("place", WIND), "by_side", 0.3, 0.3),
    ],
)
def test_a_parameter_that_varies_is_found_alone_with_its_size(value, variation, kind, size, error):
    found = named(variation.parameter, value, variation)
    (only,) = variations(found)
    assert (only.identity, only.kind) == (variation.parameter.identity, kind)
    assert only.size == pytest.approx(size, rel=error)
    if kind != "between_shots":
        assert only.interval[0] < size < only.interval[1]
    if kind == "by_side":
        assert found.distortion is None  # it is no error of the cameras
        assert WIND in [found.explainer.evidence.columns[k] for k in found.explanation.causes]


@pytest.mark.parametrize(("hypothesis", "value"), [(DRAG, 0.45), (WIND, 0.3)])
def test_a_cause_that_all_shots_have_is_no_variation(hypothesis, value):
    assert variations(named(hypothesis, value)) == ()
