"""Missing lift is not named gravity without spin labels."""

import numpy as np

from rallygap.models.gap.fit.refit import refit
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.name.missing_lift import lift_test
from tests.models.gap.hidden import SETTINGS, WITHOUT_MAGNUS, listed, measured


def gravity_off(found):
    """By how many standard errors gravity differs from the true one."""
    hypothesis = Hypothesis("gravity", "g")
    evidence = Evidence.of(found.linear, found.noise_estimate, SETTINGS)
    test = evidence.score_test([evidence.columns.index(hypothesis)], evidence.free)
    return (hypothesis.value(found.simulator) - 9.81) / test.standard_error[0]


def test_missing_magnus_is_found_and_gravity_stays():
    shots = measured(count=40, labels=None)
    without = refit(shots, WITHOUT_MAGNUS, listed(WITHOUT_MAGNUS), SETTINGS.fit)
    found = lift_test(shots, without, SETTINGS)
    assert found.p_value < 1e-6
    assert abs(gravity_off(found.with_lift)) < 3.5
    assert abs(found.with_lift.simulator.effects["magnus"]["cm"] - 0.09) < 0.01


def test_balls_that_do_not_curve_need_no_lift():
    shots = measured(WITHOUT_MAGNUS, count=30, labels=None, seconds=0.3)
    without = refit(shots, WITHOUT_MAGNUS, listed(WITHOUT_MAGNUS), SETTINGS.fit)
    assert lift_test(shots, without, SETTINGS).p_value > 0.01
    assert np.abs(gravity_off(without)) < 3.5
