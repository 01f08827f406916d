"""Name: many causes at once, and no other."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.arena.truth import draw_truth
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.gap.fit.refit import refit
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.name.label_readings import read_labels
from rallygap.models.gap.name.missing_lift import lift_test
from rallygap.models.gap.name.naming import name
from rallygap.models.gap.settings import Question
from tests.models.gap.hidden import NOMINAL, SETTINGS, WITHOUT_MAGNUS, listed, measured

SIX = {
    "drag": {"cd": 0.42},
    "wind": {"x": 0.3},
    "side_force": {"cy": 0.025},
    "spin_dependent_drag": {"c": 0.1},
    "table_height": {"h": 0.006},
    "table_tilt": {"y": 0.0075},
}


def ball_and_table(simulator):
    """A simulator without what no unbroken shot touches."""
    effects = simulator.to_dict()
    rackets = ("racket_bounce", "net")
    return Simulator.from_dict({name: effects[name] for name in effects if name not in rackets})


def test_six_causes_at_ten_times_their_size_are_all_named():
    settings = replace(SETTINGS, name=replace(SETTINGS.name, first_shots=30))  # then all of them
    truth = NOMINAL
    for effect, values in SIX.items():
        truth = truth.amended(effect, **values)
    found = name(measured(truth, count=40, seed=1005), Question(NOMINAL, settings))
    causes = {cause.identity: cause for cause in found.fit.free}
    assert set(causes) == {f"{effect}.{key}" for effect, values in SIX.items() for key in values}
    for cause in causes.values():
        assert cause.value(found.simulator) == pytest.approx(cause.value(truth), rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("labels", ["one", "rows"])
def test_a_slow_clock_is_neither_gravity_nor_flipped_labels(labels):
    """Gravity and a spin sensor's gain act like such a clock; labels seem to contradict."""
    shots = measured(NOMINAL.amended("clock_rate", d=-0.18), count=24, seed=1, labels=labels)
    about = refit(shots, NOMINAL, (), SETTINGS.fit)
    assert read_labels(shots, about, SETTINGS).doubtful
    found = name(shots, Question(NOMINAL))
    assert not found.readings.doubtful
    assert [cause.effect for cause in found.fit.free] == ["clock_rate"]
    assert found.simulator.to_dict()["clock_rate"]["d"] == pytest.approx(-0.18, abs=0.001)


def test_flipped_labels_are_found_together_with_a_cause():
    shots = measured(NOMINAL.amended("gravity", g=10.6), count=24, seed=2)
    sign = np.ones((24, 1, 1))
    sign[[2, 5, 11, 17]] = -1.0
    found = name(replace(shots, labels=shots.labels * sign), Question(NOMINAL))
    assert found.readings.flipped == {2, 5, 11, 17}
    assert [cause.effect for cause in found.fit.free] == ["gravity"]


def test_labels_that_err_by_most_of_the_spin_are_not_used():
    truth = NOMINAL.amended("drag", cd=0.42)
    found = name(measured(truth, count=24, labels="one", label=0.9), Question(NOMINAL))
    assert found.readings.useless
    assert not found.fit.linear.labelled.any()
    assert [cause.effect for cause in found.fit.free] == ["drag"]


def gravity_off(found):
    """By how many standard errors gravity differs from the true one."""
    hypothesis = Hypothesis("gravity", "g")
    evidence = Evidence.of(found.linear, found.noise_estimate, SETTINGS)
    test = evidence.score_test([evidence.columns.index(hypothesis)], evidence.free)
    return abs(hypothesis.value(found.simulator) - 9.81) / test.standard_error[0]


@pytest.mark.parametrize("lift", [True, False])
def test_missing_lift_is_not_named_gravity_without_spin_labels(lift):
    settings = {"count": 40} if lift else {"simulator": WITHOUT_MAGNUS, "count": 30, "seconds": 0.3}
    shots = measured(**settings, labels=None)
    without = refit(shots, WITHOUT_MAGNUS, listed(WITHOUT_MAGNUS), SETTINGS.fit)
    found = lift_test(shots, without, SETTINGS)
    if lift:
        assert found.p_value < 1e-6
        assert gravity_off(found.with_lift) < 3.5
        assert found.with_lift.simulator.effects["magnus"]["cm"] == pytest.approx(0.09, abs=0.01)
    else:  # balls that do not curve need none
        assert found.p_value > 0.01
        assert gravity_off(without) < 3.5


@pytest.mark.slow
def test_only_true_causes_of_an_arena_are_named():
    truth = ball_and_table(draw_truth(1001).simulator)
    nominal = ball_and_table(shipped("imperfect_c"))
    verdict = diagnose(measured(truth, count=90, seed=1001), nominal)
    assert {cause.effect for cause in verdict.causes} <= {*truth.effects, *nominal.effects}
    assert len(verdict.causes) >= 9
    assert verdict.gap.removable_closed == pytest.approx(1.0, abs=0.15)
