"""Scores of shots: noise that is correlated within a shot."""

from itertools import product

import numpy as np
import pytest

from rallygap.models.exam.methods.regression import Regression
from rallygap.models.exam.methods.shot_scores import score_gram, term_norms
from rallygap.models.gap.hypotheses import Hypothesis

COLUMNS = tuple(
    Hypothesis(effect, axis) for effect, axis in product(("wind", "spin_axis_bias"), "xyz")
)


def rows(shots=100, samples=20, common=0.0, seed=0):
    """Six terms, and noise with a part that is proportional to a term all along a shot."""
    random = np.random.default_rng(seed)
    terms = random.standard_normal((shots, samples, 6))
    noise = random.standard_normal((shots, samples)) + common * terms[..., 0] * (
        random.standard_normal((shots, 1))
    )
    return np.concatenate([terms, noise[..., None]], axis=2)


def regression(table):
    return Regression(COLUMNS, np.swapaxes(table, 1, 2) @ table, tuple((one,) for one in COLUMNS))


def standardised(common):
    """Return (200, 6) least-squares coefficients in noise, in the errors that scores give them."""
    found = []
    for seed in range(200):
        gram = score_gram(regression(rows(common=common, seed=seed)))
        inverse = np.linalg.inv(gram[:-1, :-1])
        found.append(inverse @ gram[:-1, -1] / np.sqrt(np.diag(inverse)))
    return np.array(found)


def test_scores_of_independent_rows_have_the_gram_matrix_of_the_rows():
    one = regression(rows(shots=4000))
    expected = one.total[:-1, :-1]
    assert score_gram(one)[:-1, :-1] == pytest.approx(expected, abs=0.04 * expected.max())


@pytest.mark.parametrize("common", [0.0, 2.0])
def test_coefficients_are_as_far_from_the_truth_as_their_errors_say(common):
    spread = standardised(common).std(axis=0)
    assert spread == pytest.approx(np.ones(6), abs=0.2)


def test_without_scores_of_shots_errors_within_a_shot_are_taken_for_an_effect():
    naive = [regression(rows(common=2.0, seed=seed)) for seed in range(50)]
    scores = np.array([one.total[0, -1] for one in naive]) / term_norms(naive[0])[0]
    assert scores.std() > 3.0


def test_copies_of_rows_are_no_more_evidence_than_one():
    table = 3.0 * rows(common=1.0)
    one, copied = regression(table), regression(np.repeat(table, 5, axis=1))
    assert score_gram(copied) == pytest.approx(score_gram(one), rel=1e-3, abs=1e-3)


def test_scores_do_not_depend_on_the_units_of_terms():
    table, scale = rows(common=1.0), np.array([1e-3, 1.0, 1e3, 1.0, 1.0, 1.0, 1.0])
    expected = score_gram(regression(table)) * np.outer(scale, scale)
    assert score_gram(regression(table * scale)) == pytest.approx(expected)
