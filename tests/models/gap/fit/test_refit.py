"""Refit: values come back, and a hidden effect leads the evidence."""

from dataclasses import replace

import numpy as np
import pytest

from models.gap.fit.linearize import linearise
from models.gap.fit.refit import likelihood_gain, refit
from models.gap.hypotheses import Hypothesis
from models.gap.inference.score_test import Evidence, familywise_p_values
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured, own

# About three times what 100 shots can show.
HIDDEN = {
    ("clock_rate", "d"): 0.026,
    ("frame_tilt", "x"): 0.004,
    ("frame_tilt", "y"): 0.004,
    ("lift_saturation", "kappa"): 0.15,
    ("linear_drag", "k1"): 0.046,
    ("position_scale", "s"): 0.024,
    ("side_force", "cy"): 0.005,
    ("slip_dependent_friction", "c"): 0.0095,
    ("speed_dependent_drag", "c"): 0.029,
    ("speed_dependent_latency", "tau"): 3.5e-4,
    ("speed_dependent_restitution", "c"): 0.05,
    ("spin_axis_bias", "x"): 0.055,
    ("spin_axis_bias", "y"): 0.023,
    ("spin_axis_bias", "z"): 0.023,
    ("spin_decay", "c"): 0.0073,
    ("spin_dependent_drag", "c"): 0.021,
    ("spin_dependent_restitution", "c"): 0.0147,
    ("spin_gain", "s"): 0.026,
    ("table_height", "h"): 0.00114,
    ("table_tilt", "x"): 0.0032,
    ("table_tilt", "y"): 0.0014,
    ("tangential_elasticity", "et"): 0.27,
    ("wind", "x"): 0.055,
    ("wind", "y"): 0.03,
    ("wind", "z"): 0.17,
}
QUICK = [("side_force", "cy"), ("table_tilt", "x"), ("spin_axis_bias", "z")]
FAR = {"drag": {"cd": 0.4}, "table_bounce": {"restitution": 0.9, "friction": 0.25}}


def leader(evidence):
    """The missing effect of the largest significant gain, and its test."""
    places = [k for k in evidence.decidable(evidence.free) if not evidence.listed[k]]
    tests = [evidence.score_test([k], evidence.free) for k in places]
    significant = familywise_p_values(tests) < 0.003
    gains = [test.gain * sure for test, sure in zip(tests, significant, strict=True)]
    best = int(np.argmax(gains))
    return evidence.columns[places[best]], tests[best]


def check_leads(effect, parameter, count):
    hypothesis = Hypothesis(effect, parameter)
    size = HIDDEN[effect, parameter] * np.sqrt(100 / count)
    shots = measured(hypothesis.at(NOMINAL, size), count=count, seed=2)
    found = refit(shots, NOMINAL, own(NOMINAL), settings=SETTINGS.fit)
    evidence = Evidence.of(found.linear, found.noise_estimate, settings=SETTINGS)
    first, test = leader(evidence)
    assert test.gain > 50.0
    places = [evidence.columns.index(one) for one in (hypothesis, first)]
    assert first == hypothesis or evidence.correlation(*places, evidence.free) > 0.99


@pytest.mark.parametrize(("effect", "parameter"), QUICK)
def test_a_hidden_effect_leads(effect, parameter):
    check_leads(effect, parameter, count=40)


@pytest.mark.slow
@pytest.mark.parametrize(("effect", "parameter"), HIDDEN)
def test_every_hidden_effect_or_one_of_its_class_leads(effect, parameter):
    check_leads(effect, parameter, count=100)


def test_wrong_values_come_back_within_their_errors():
    shots = measured(count=40)
    far = NOMINAL
    for effect, values in FAR.items():
        far = far.amended(effect, **values)
    found = refit(shots, far, own(far), settings=SETTINGS.fit)
    for hypothesis in own(NOMINAL):
        evidence = Evidence.of(found.linear, found.noise_estimate, settings=SETTINGS)
        test = evidence.score_test([evidence.columns.index(hypothesis)], evidence.free)
        off = hypothesis.value(found.simulator) - hypothesis.value(NOMINAL)
        assert abs(off) < 3.5 * test.standard_error[0]


def test_values_of_which_shots_say_nothing_stay():
    shots = measured(count=8, seconds=0.15, labels=None)
    found = refit(shots, NOMINAL, own(NOMINAL), settings=SETTINGS.fit).simulator
    assert found.effects["table_bounce"] == NOMINAL.effects["table_bounce"]
    assert found.effects["drag"]["cd"] == pytest.approx(0.5, abs=0.25)


def test_a_start_about_which_nothing_fits_is_no_trap():
    shots = measured(count=20)
    start = NOMINAL.amended("gravity", g=2.0).amended("drag", cd=1.4)
    free = (Hypothesis("gravity", "g"), Hypothesis("drag", "cd"))
    found = refit(shots, start, free, settings=SETTINGS.fit).simulator
    assert found.effects["gravity"]["g"] == pytest.approx(9.81, abs=0.1)
    assert found.effects["drag"]["cd"] == pytest.approx(0.5, abs=0.02)


def test_nothing_is_significant_in_a_clean_set():
    found = refit(measured(count=40, seed=6), NOMINAL, own(NOMINAL), settings=SETTINGS.fit)
    evidence = Evidence.of(found.linear, found.noise_estimate, settings=SETTINGS)
    tests = [evidence.score_test([k], evidence.free) for k in evidence.decidable(evidence.free)]
    assert familywise_p_values(tests).min() > 0.003


def test_shots_are_likelier_about_the_simulator_with_the_hidden_effect():
    shots = measured(NOMINAL.amended("side_force", cy=0.005), count=20)
    before = refit(shots, NOMINAL, (), settings=SETTINGS.fit)
    after = refit(shots, NOMINAL, (Hypothesis("side_force", "cy"),), SETTINGS.fit, before)
    assert after.simulator.effects["side_force"]["cy"] == pytest.approx(0.005, abs=0.001)
    assert likelihood_gain(before, after) > 30.0
    assert likelihood_gain(after, before) < 0.0
    assert likelihood_gain(after, after) == 0.0


def test_labels_that_only_one_of_two_fits_can_use_are_not_compared():
    found = refit(measured(count=10, seed=4), NOMINAL, (), settings=SETTINGS.fit)
    labels, labelled = found.linear.labels.copy(), found.linear.labelled.copy()
    labels[0], labelled[0] = 0.0, False
    half = replace(found, linear=replace(found.linear, labels=labels, labelled=labelled))
    assert likelihood_gain(half, found) == likelihood_gain(found, half) == 0.0


def test_stronger_lift_is_likelier_although_it_makes_spins_smaller():
    """Labels err by a share of the spin, so the same errors weigh more about smaller spins."""
    lift = Hypothesis("magnus", "cm")
    shots = measured(NOMINAL.amended("magnus", cm=0.094), count=30, seed=3)
    before, after = (refit(shots, NOMINAL, free, settings=SETTINGS.fit) for free in ((), (lift,)))
    assert likelihood_gain(before, after) > 20.0


def test_one_path_is_as_likely_by_a_slow_clock_as_by_what_does_its_work():
    """To a clock of rate r balls fly as if they and their spins were 1/r as fast: so is g / r^2."""
    slow = NOMINAL.amended("clock_rate", d=-0.18)
    shots = measured(slow, count=10, seed=3)
    clock = refit(shots, slow, (), settings=SETTINGS.fit)
    faster = clock.linear.nuisance.copy()
    faster[:, 3:9] /= 0.82
    other = NOMINAL.amended("gravity", g=9.81 / 0.82**2).amended("spin_gain", s=0.82 - 1.0)
    alike = replace(clock, linear=linearise(shots, other, faster, ()))
    assert likelihood_gain(clock, alike) == pytest.approx(0.0, abs=1.0)
