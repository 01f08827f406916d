"""Evidence: closed forms, chances under no effect, and what must not matter."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from models.ball.simulator import Simulator
from models.gap.fit.linearize import linearise
from models.gap.fit.noise import Noise, gram_matrices
from models.gap.fit.shots import Shots
from models.gap.fit.variance_components import NoiseEstimate
from models.gap.hypotheses import Hypothesis
from models.gap.inference.score_test import Evidence, familywise_p_values
from tests.models.gap.hidden import SETTINGS

SIGMA = 0.003
NOISE = Noise(white=SIGMA, slow=1e-9, timing=0.0)
GRAVITY = (Hypothesis("gravity", "g"),)


def parabolas(count=5, seed=0):
    """Shots without air, their residuals, and the part of -t^2/2 that no straight line has."""
    random = np.random.default_rng(seed)
    t = np.arange(0.0, 0.4, 0.01)
    start = random.uniform(1, 2, (count, 1, 6))
    errors = SIGMA * random.standard_normal((count, len(t), 3))
    fall = np.array([0.0, 0.0, -9.81 / 2]) * t[:, None] ** 2
    places = start[..., :3] + start[..., 3:] * t[:, None] + fall + errors
    line = np.stack([np.ones_like(t), t], axis=1)
    bend = -(t**2) / 2
    bend = bend - line @ np.linalg.lstsq(line, bend, rcond=None)[0]
    shots = Shots.from_arrays([t + 3.0] * count, list(places))
    return shots, start[:, 0], errors, bend


def evidence_of(shots, states, columns=GRAVITY, simulator=None, noise=NOISE):
    simulator = simulator or Simulator.from_dict({"gravity": {"g": 9.81}})
    nuisance = np.hstack([states, np.zeros((len(states), 3))])
    linear = linearise(shots, simulator, nuisance, columns)
    weights, shot_weights = np.ones(shots.times.shape), np.ones(len(shots))
    total = gram_matrices(linear, noise, weights, shot_weights).total(noise)
    return Evidence.of(
        linear, NoiseEstimate(noise, weights, shot_weights, total), settings=SETTINGS
    )


def test_gravity_without_air_has_its_closed_form():
    shots, states, errors, bend = parabolas()
    evidence = evidence_of(shots, states)
    assert evidence.scores[:, 0] == pytest.approx(errors[..., 2] @ bend / SIGMA**2, rel=1e-4)
    assert evidence.information[:, 0, 0] == pytest.approx(bend @ bend / SIGMA**2, rel=1e-4)
    test = evidence.score_test([0], [])
    error = SIGMA / np.sqrt(len(shots) * bend @ bend)
    assert test.standard_error[0] == pytest.approx(error, rel=1e-4)
    assert evidence.minimum_detectable_effect(0, []) == pytest.approx(5.8 * error, rel=1e-4)


def test_the_start_of_a_fit_does_not_matter():
    shots, states, _, _ = parabolas()
    shifted = evidence_of(shots, states + 0.01)
    assert shifted.scores == pytest.approx(evidence_of(shots, states).scores, rel=1e-4)


def test_the_order_of_shots_does_not_matter():
    shots, states, _, _ = parabolas()
    order = np.array([3, 1, 4, 0, 2])
    turned = evidence_of(shots[order], states[order])
    assert turned.scores == pytest.approx(evidence_of(shots, states).scores[order], rel=1e-9)


def test_turning_the_frame_about_the_vertical_leaves_gravity_alone():
    shots, states, _, _ = parabolas()
    turn = np.array([-1.0, -1.0, 1.0])
    turned = Shots(**{**vars(shots), "positions": shots.positions * turn})
    evidence = evidence_of(turned, states * np.tile(turn, 2))
    assert evidence.scores == pytest.approx(evidence_of(shots, states).scores, rel=1e-6)


def test_what_is_exactly_alike_cannot_be_decided():
    shots, states, _, _ = parabolas()
    columns = (*GRAVITY, Hypothesis("buoyancy", "b"), Hypothesis("drag", "cd"))
    evidence = evidence_of(shots, states, columns)
    assert evidence.free == (0,)
    assert evidence.decidable(evidence.free) == (0, 2)
    assert evidence.decidable([]) == (0, 1, 2)
    assert evidence.correlation(0, 1, []) == pytest.approx(1.0, abs=1e-9)


def drawn(random, shots=40, columns=6, effect=0.0):
    """Evidence of a linear model: shots of unequal information, errors twice what is believed."""
    rows = random.standard_normal((shots, 12, columns)) * random.uniform(0.3, 2, (shots, 1, 1))
    rows[..., 1] += 0.9 * rows[..., 0]
    errors = 2 * random.standard_normal((shots, 12)) + effect * rows[..., 2]
    listed = np.arange(columns) < 2
    names = tuple(Hypothesis("wind", "x") for _ in range(columns))
    information = np.swapaxes(rows, 1, 2) @ rows
    return Evidence(
        names, listed, np.einsum("brk,br->bk", rows, errors), information, settings=SETTINGS
    )


def p_value(evidence, blocks=((2,), (3,), (4, 5))):
    return familywise_p_values([evidence.score_test(block, evidence.free) for block in blocks])


def believed(evidence):
    """The same evidence where the noise is believed to be what it is."""
    return replace(evidence, scores=evidence.scores / 4, information=evidence.information / 4)


def shown_by(evidence, shots):
    """Evidence of which the third number shows in some shots alone."""
    shown = np.ones((len(evidence.scores), evidence.scores.shape[1]))
    shown[:, 2] = np.isin(np.arange(len(shown)), shots)
    information = evidence.information * shown[:, :, None] * shown[:, None]
    return replace(evidence, scores=evidence.scores * shown, information=information)


def test_chances_are_uniform_where_there_is_no_effect():
    random = np.random.default_rng(0)
    least = [p_value(believed(drawn(random))).min() for _ in range(120)]
    assert kstest(least, "uniform").pvalue > 0.01


def test_surprises_of_shots_alike_are_their_distances_from_the_mean():
    scores = np.array([1.0, 4.0, -2.0, 0.0])[:, None]
    test = Evidence(
        GRAVITY, np.array([False]), scores, np.ones((4, 1, 1)), settings=SETTINGS
    ).score_test([0], [])
    assert test.effective_sample_size == pytest.approx(4.0)
    assert test.leave_one_out_residuals == pytest.approx(4 / 3 * (scores - scores.mean()))
    between = (test.leave_one_out_residuals**2).sum()
    assert test.variance == pytest.approx((3 * between + 8 * 4) / 11)


def test_what_six_shots_in_sixty_say_plainly_is_heard():
    random = np.random.default_rng(4)
    evidence = believed(shown_by(drawn(random, shots=60, effect=3.0), range(0, 60, 10)))
    test = evidence.score_test([2], evidence.free)
    assert 2.5 < test.effective_sample_size < 6.1
    assert familywise_p_values([test])[0] < 1e-4
    assert abs(test.estimate[0] - 3.0) < test.margin[0]


def test_one_shot_that_is_far_off_says_nothing():
    evidence = believed(shown_by(drawn(np.random.default_rng(5), shots=60), range(0, 60, 10)))
    evidence.scores[10, 2] += 12 * np.sqrt(evidence.information[10, 2, 2])
    test = evidence.score_test([2], evidence.free)
    assert test.gain > 20.0
    assert test.p_value > 0.01


def test_margins_hold_the_truth_as_often_as_they_say():
    random, inside = np.random.default_rng(6), []
    for _ in range(150):
        test = drawn(random, shots=20, effect=0.5).score_test([2], [0, 1])
        inside.append(abs(test.estimate[0] - 0.5) < test.margin[0])
    assert 0.88 < np.mean(inside) < 0.99


def test_a_noise_believed_too_small_does_not_make_effects():
    random = np.random.default_rng(1)
    least = np.array([p_value(drawn(random)).min() for _ in range(80)])
    assert np.mean(least < 0.05) < 0.1


def test_an_effect_is_found_at_its_place_with_its_size():
    evidence = drawn(np.random.default_rng(2), effect=0.7)
    tests = [evidence.score_test([k], evidence.free) for k in (2, 3, 4, 5)]
    assert familywise_p_values(tests)[0] < 1e-3
    assert np.all(familywise_p_values(tests)[1:] > 0.003)
    assert tests[0].estimate[0] == pytest.approx(0.7, abs=6 * tests[0].standard_error[0])


def test_no_verdict_rests_on_one_shot():
    evidence = drawn(np.random.default_rng(3))
    evidence.information[0] *= 1e6
    assert evidence.score_test([2], evidence.free).effective_sample_size < 2
    assert evidence.decidable(evidence.free) == ()
