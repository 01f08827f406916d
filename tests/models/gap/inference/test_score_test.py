"""Score tests: closed forms, p-values without an effect, invariances."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.fit.linearize import linearise
from rallygap.models.gap.fit.noise import Noise, gram_matrices
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.fit.variance_components import NoiseEstimate
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.inference.score_test import Evidence, familywise_p_values
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


def evidence_of(shots, states, columns=GRAVITY):
    simulator = Simulator.from_dict({"gravity": {"g": 9.81}})
    nuisance = np.hstack([states, np.zeros((len(states), 3))])
    linear = linearise(shots, simulator, nuisance, columns)
    weights, shot_weights = np.ones(shots.times.shape), np.ones(len(shots))
    total = gram_matrices(linear, NOISE, weights, shot_weights).total(NOISE)
    return Evidence.of(linear, NoiseEstimate(NOISE, weights, shot_weights, total), SETTINGS)


def test_gravity_without_air_has_its_closed_form():
    shots, states, errors, bend = parabolas()
    evidence = evidence_of(shots, states)
    assert evidence.scores[:, 0] == pytest.approx(errors[..., 2] @ bend / SIGMA**2, rel=1e-4)
    assert evidence.information[:, 0, 0] == pytest.approx(bend @ bend / SIGMA**2, rel=1e-4)
    test = evidence.score_test([0], [])
    error = SIGMA / np.sqrt(len(shots) * bend @ bend)
    assert test.standard_error[0] == pytest.approx(error, rel=1e-4)
    assert evidence.minimum_detectable_effect(0, []) == pytest.approx(5.8 * error, rel=1e-4)


def test_start_order_and_a_rotation_about_the_vertical_do_not_matter():
    shots, states, _, _ = parabolas()
    scores = evidence_of(shots, states).scores
    assert evidence_of(shots, states + 0.01).scores == pytest.approx(scores, rel=1e-4)
    order = np.array([3, 1, 4, 0, 2])
    assert evidence_of(shots[order], states[order]).scores == pytest.approx(scores[order], rel=1e-9)
    half_turn = np.array([-1.0, -1.0, 1.0])
    rotated = replace(shots, positions=shots.positions * half_turn)
    evidence = evidence_of(rotated, states * np.tile(half_turn, 2))
    assert evidence.scores == pytest.approx(scores, rel=1e-6)


def test_exactly_collinear_hypotheses_are_not_decidable():
    shots, states, _, _ = parabolas()
    columns = (*GRAVITY, Hypothesis("buoyancy", "b"), Hypothesis("drag", "cd"))
    evidence = evidence_of(shots, states, columns)
    assert evidence.free == (0,)
    assert evidence.decidable(evidence.free) == (0, 2)
    assert evidence.decidable([]) == (0, 1, 2)


def drawn(random, shots=40, columns=6, effect=0.0):
    """Evidence of a linear model: shots of unequal information, errors of twice the noise."""
    rows = random.standard_normal((shots, 12, columns)) * random.uniform(0.3, 2, (shots, 1, 1))
    rows[..., 1] += 0.9 * rows[..., 0]
    errors = 2 * random.standard_normal((shots, 12)) + effect * rows[..., 2]
    listed = np.arange(columns) < 2
    names = tuple(Hypothesis("wind", "x") for _ in range(columns))
    information = np.swapaxes(rows, 1, 2) @ rows
    return Evidence(names, listed, np.einsum("brk,br->bk", rows, errors), information, SETTINGS)


def least_p_value(evidence):
    blocks = (2,), (3,), (4, 5)
    tests = [evidence.score_test(block, evidence.free) for block in blocks]
    return familywise_p_values(tests).min()


def with_true_noise(evidence):
    """The same evidence in the noise that the errors have."""
    return replace(evidence, scores=evidence.scores / 4, information=evidence.information / 4)


def shown_by(evidence, shots):
    """Evidence of which the third number shows in some shots alone."""
    shown = np.ones((len(evidence.scores), evidence.scores.shape[1]))
    shown[:, 2] = np.isin(np.arange(len(shown)), shots)
    information = evidence.information * shown[:, :, None] * shown[:, None]
    return replace(evidence, scores=evidence.scores * shown, information=information)


def test_p_values_are_uniform_without_an_effect():
    random = np.random.default_rng(0)
    least = [least_p_value(with_true_noise(drawn(random))) for _ in range(120)]
    assert kstest(least, "uniform").pvalue > 0.01


def test_residuals_of_shots_of_equal_information_are_distances_from_the_mean():
    scores = np.array([1.0, 4.0, -2.0, 0.0])[:, None]
    test = Evidence(GRAVITY, np.array([False]), scores, np.ones((4, 1, 1)), SETTINGS).score_test(
        [0], []
    )
    assert test.effective_sample_size == pytest.approx(4.0)
    assert test.leave_one_out_residuals == pytest.approx(4 / 3 * (scores - scores.mean()))
    between = (test.leave_one_out_residuals**2).sum()
    assert test.variance == pytest.approx((3 * between + 8 * 4) / 11)


def test_an_effect_that_six_of_sixty_shots_show_is_significant_and_one_outlying_shot_is_not():
    six = range(0, 60, 10)
    evidence = with_true_noise(shown_by(drawn(np.random.default_rng(4), 60, effect=3.0), six))
    test = evidence.score_test([2], evidence.free)
    assert 2.5 < test.effective_sample_size < 6.1
    assert familywise_p_values([test])[0] < 1e-4
    assert abs(test.estimate[0] - 3.0) < test.margin[0]

    evidence = with_true_noise(shown_by(drawn(np.random.default_rng(5), 60), six))
    evidence.scores[10, 2] += 12 * np.sqrt(evidence.information[10, 2, 2])
    test = evidence.score_test([2], evidence.free)
    assert test.gain > 20.0
    assert test.p_value > 0.01


def test_margins_have_their_coverage():
    random, inside = np.random.default_rng(6), []
    for _ in range(150):
        test = drawn(random, shots=20, effect=0.5).score_test([2], [0, 1])
        inside.append(abs(test.estimate[0] - 0.5) < test.margin[0])
    assert 0.88 < np.mean(inside) < 0.99


def test_only_the_true_effect_is_significant_with_its_size():
    evidence = drawn(np.random.default_rng(2), effect=0.7)
    tests = [evidence.score_test([k], evidence.free) for k in (2, 3, 4, 5)]
    assert familywise_p_values(tests)[0] < 1e-3
    assert np.all(familywise_p_values(tests)[1:] > 0.003)
    assert tests[0].estimate[0] == pytest.approx(0.7, abs=6 * tests[0].standard_error[0])
    # Underestimated noise makes no effects.
    random = np.random.default_rng(1)
    least = np.array([least_p_value(drawn(random)) for _ in range(80)])
    assert np.mean(least < 0.05) < 0.1


def test_no_verdict_rests_on_one_shot():
    evidence = drawn(np.random.default_rng(3))
    evidence.information[0] *= 1e6
    assert evidence.score_test([2], evidence.free).effective_sample_size < 2
    assert evidence.decidable(evidence.free) == ()
