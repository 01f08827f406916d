"""Refit: values come back, and a hidden effect has the largest evidence."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.gap.fit.linearize import linearise
from rallygap.models.gap.fit.refit import likelihood_gain, likelihood_gains, refit
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.inference.score_test import Evidence, familywise_p_values
from tests.models.gap.hidden import NOMINAL, SETTINGS, listed, measured

# Effects of each kind, about three times what 100 shots can show.
HIDDEN = {
    ("clock_rate", "d"): 0.026,
    ("lift_saturation", "kappa"): 0.15,
    ("linear_drag", "k1"): 0.046,
    ("position_scale", "s"): 0.024,
    ("side_force", "cy"): 0.005,
    ("slip_dependent_friction", "c"): 0.0095,
    ("speed_dependent_drag", "c"): 0.029,
    ("speed_dependent_restitution", "c"): 0.05,
    ("spin_axis_bias", "z"): 0.023,
    ("spin_decay", "c"): 0.0073,
    ("table_tilt", "x"): 0.0032,
    ("tangential_elasticity", "et"): 0.27,
}
QUICK = [("table_tilt", "x"), ("spin_axis_bias", "z")]


def refitted(shots, simulator=NOMINAL):
    """The shots with all listed parameters refitted, and their evidence."""
    found = refit(shots, simulator, listed(simulator), SETTINGS.fit)
    return found, Evidence.of(found.linear, found.noise_estimate, SETTINGS)


@pytest.mark.parametrize(
    ("effect", "parameter", "count"),
    [
        *((*name, 40) for name in QUICK),
        *(pytest.param(*name, 100, marks=pytest.mark.slow) for name in HIDDEN),
    ],
)
def test_a_hidden_effect_or_one_of_its_class_has_the_largest_evidence(effect, parameter, count):
    hypothesis = Hypothesis(effect, parameter)
    size = HIDDEN[effect, parameter] * np.sqrt(100 / count)
    _, evidence = refitted(measured(hypothesis.at(NOMINAL, size), count=count, seed=2))
    places = [k for k in evidence.decidable(evidence.free) if not evidence.listed[k]]
    tests = [evidence.score_test([k], evidence.free) for k in places]
    significant = familywise_p_values(tests) < 0.003
    gains = significant * np.array([test.gain for test in tests])
    assert gains.max() > 50.0
    first, true = places[gains.argmax()], evidence.columns.index(hypothesis)
    pair = evidence.score_test([true, first], evidence.free).information
    assert first == true or pair[0, 1] ** 2 > 0.98 * pair[0, 0] * pair[1, 1]


def test_wrong_values_come_back_within_their_errors():
    far = NOMINAL.amended("drag", cd=0.4).amended("table_bounce", restitution=0.9)
    found, evidence = refitted(measured(count=40), far)
    for hypothesis in listed(NOMINAL):
        test = evidence.score_test([evidence.columns.index(hypothesis)], evidence.free)
        off = hypothesis.value(found.simulator) - hypothesis.value(NOMINAL)
        assert abs(off) < 3.5 * test.standard_error[0]


def test_a_refit_converges_from_a_start_about_which_nothing_fits_and_keeps_unseen_values():
    start = NOMINAL.amended("gravity", g=2.0).amended("drag", cd=1.4)
    free = (Hypothesis("gravity", "g"), Hypothesis("drag", "cd"))
    found = refit(measured(count=20), start, free, SETTINGS.fit).simulator
    assert found.effects["gravity"]["g"] == pytest.approx(9.81, abs=0.1)
    assert found.effects["drag"]["cd"] == pytest.approx(0.5, abs=0.02)
    unseen = refitted(measured(count=8, seconds=0.15, labels=None))[0].simulator
    assert unseen.effects["table_bounce"] == NOMINAL.effects["table_bounce"]
    assert unseen.effects["drag"]["cd"] == pytest.approx(0.5, abs=0.25)


def test_shots_are_likelier_about_the_simulator_with_the_hidden_effect():
    shots = measured(NOMINAL.amended("side_force", cy=0.005), count=20)
    before = refit(shots, NOMINAL, (), SETTINGS.fit)
    after = refit(shots, NOMINAL, (Hypothesis("side_force", "cy"),), SETTINGS.fit, before)
    assert after.simulator.effects["side_force"]["cy"] == pytest.approx(0.005, abs=0.001)
    assert likelihood_gain(before, after) > 30.0
    assert likelihood_gain(after, before) < 0.0
    assert likelihood_gain(after, after) == 0.0
    assert likelihood_gains(before, after).sum() == pytest.approx(likelihood_gain(before, after))


def test_only_labels_that_both_fits_use_are_compared():
    found = refit(measured(count=10, seed=4), NOMINAL, (), SETTINGS.fit)
    labels, labelled = found.linear.labels.copy(), found.linear.labelled.copy()
    labels[0], labelled[0] = 0.0, False
    half = replace(found, linear=replace(found.linear, labels=labels, labelled=labelled))
    assert likelihood_gain(half, found) == likelihood_gain(found, half) == 0.0


def test_stronger_lift_is_likelier_although_it_makes_spins_smaller():
    """Labels err by a share of the spin, so the same errors weigh more about smaller spins."""
    lift = Hypothesis("magnus", "cm")
    shots = measured(NOMINAL.amended("magnus", cm=0.094), count=30, seed=3)
    before, after = (refit(shots, NOMINAL, free, SETTINGS.fit) for free in ((), (lift,)))
    assert likelihood_gain(before, after) > 20.0


def test_a_path_is_as_likely_by_a_slow_clock_as_by_an_equivalent_gravity_and_spin_gain():
    """By a clock of rate r balls and their spins are 1/r as fast, with gravity g / r^2."""
    slow = NOMINAL.amended("clock_rate", d=-0.18)
    shots = measured(slow, count=10, seed=3)
    clock = refit(shots, slow, (), SETTINGS.fit)
    faster = clock.linear.nuisance.copy()
    faster[:, 3:9] /= 0.82
    other = NOMINAL.amended("gravity", g=9.81 / 0.82**2).amended("spin_gain", s=0.82 - 1.0)
    alike = replace(clock, linear=linearise(shots, other, faster, ()))
    assert likelihood_gain(clock, alike) == pytest.approx(0.0, abs=1.0)
