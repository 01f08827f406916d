"""Selection by evidence, against densities of normal distributions and exhaustive search."""

from itertools import chain, combinations, product

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from experiments.exam.methods.evidence import greedy, log_evidence, posterior, score_gram
from experiments.exam.methods.regression import Regression
from rallygap.models.gap.hypotheses import Hypothesis

WIDTHS = np.array([0.7, 2.0, 0.1, 5.0])
COLUMNS = tuple(
    Hypothesis(effect, axis) for effect, axis in product(("wind", "spin_axis_bias"), "xyz")
)


def gram(terms, measured):
    rows = np.column_stack([terms, measured])
    return rows.T @ rows


def drawn(*coefficients, seed=0, samples=60):
    """Terms of independent samples, and a sum of them in unit noise."""
    random = np.random.default_rng(seed)
    terms = random.standard_normal((samples, len(coefficients)))
    return terms, terms @ coefficients + random.standard_normal(samples)


def subsets(count):
    return chain.from_iterable(combinations(range(count), size) for size in range(count + 1))


def log_density(terms, measured, widths):
    covariance = np.eye(len(measured)) + (terms * widths**2) @ terms.T
    return multivariate_normal(np.zeros(len(measured)), covariance).logpdf(measured)


@pytest.mark.parametrize("places", [(), (1,), (0, 3), (0, 1, 2, 3)])
def test_the_evidence_is_a_ratio_of_normal_densities(places):
    terms, measured = drawn(0.5, 0.0, 1.0, -0.2)
    some = list(places)
    expected = log_density(terms[:, some], measured, WIDTHS[some])
    expected -= log_density(terms[:, []], measured, WIDTHS[[]])
    assert log_evidence(gram(terms, measured), WIDTHS, places) == pytest.approx(expected)


def test_the_posterior_is_the_conditional_normal_distribution():
    terms, measured = drawn(0.5, 0.0, 1.0, -0.2)
    some = [0, 2, 3]
    kept, prior = terms[:, some], np.diag(WIDTHS[some] ** 2)
    gain = prior @ kept.T @ np.linalg.inv(np.eye(60) + kept @ prior @ kept.T)
    mean, deviation = posterior(gram(terms, measured), WIDTHS, (0, 2, 3))
    assert mean == pytest.approx(gain @ measured)
    assert deviation == pytest.approx(np.sqrt(np.diag(prior - gain @ kept @ prior)))


def one_for_two():
    """Terms of which one, the best alone, stands for the two others, and a sum of these."""
    terms, measured = drawn(1.0, 1.0, 0.0, samples=400)
    noise = np.random.default_rng(5).standard_normal(400)
    terms[:, 2] = terms[:, 0] + terms[:, 1] + 0.5 * noise
    return terms, measured


@pytest.mark.parametrize(
    "rows", [one_for_two(), *(drawn(1.0, 0.0, 0.4, -0.3, 0.1, seed=seed) for seed in range(4))]
)
def test_greedy_search_finds_the_best_of_all_sets(rows):
    table, count = gram(*rows), rows[0].shape[1]
    widths = np.full(count, 2.0)
    best = max(subsets(count), key=lambda some: log_evidence(table, widths, some) - 2 * len(some))
    assert greedy(table, widths, 2.0) == best


def test_planted_terms_are_found_whatever_their_scale_and_none_in_noise():
    coefficients = np.zeros(30)
    coefficients[[4, 11, 27]] = 1.0, -1.5, 2.0
    table, scale = gram(*drawn(*coefficients, samples=200)), np.geomspace(1e-6, 1e6, 30)
    whole = np.append(scale, 1.0)
    scaled = table * np.outer(whole, whole)
    assert greedy(table, np.full(30, 3.0), 5.0) == (4, 11, 27)
    assert greedy(scaled, 3.0 / scale, 5.0) == (4, 11, 27)
    noise = (gram(*drawn(*np.zeros(30), seed=seed)) for seed in range(10))
    assert [greedy(of_noise, np.full(30, 5.0), 5.0) for of_noise in noise] == [()] * 10


def rows(shots=100, samples=20, common=0.0, seed=0):
    """Six terms, and noise with a part that is proportional to a term all along a shot."""
    random = np.random.default_rng(seed)
    terms = random.standard_normal((shots, samples, 6))
    noise = random.standard_normal((shots, samples)) + common * terms[..., 0] * (
        random.standard_normal((shots, 1))
    )
    return np.concatenate([terms, noise[..., None]], axis=2)


def regression(table):
    return Regression(
        COLUMNS, np.swapaxes(table, 1, 2) @ table, tuple((column,) for column in COLUMNS)
    )


@pytest.mark.parametrize("common", [0.0, 2.0])
def test_coefficients_are_as_far_from_the_truth_as_their_errors_say(common):
    coefficients = []
    for seed in range(200):
        table = score_gram(regression(rows(common=common, seed=seed)))
        inverse = np.linalg.inv(table[:-1, :-1])
        coefficients.append(inverse @ table[:-1, -1] / np.sqrt(np.diag(inverse)))
    assert np.std(coefficients, axis=0) == pytest.approx(np.ones(6), abs=0.2)


def test_copies_of_rows_are_no_more_evidence_than_one():
    table = 3.0 * rows(common=1.0)
    one, copied = regression(table), regression(np.repeat(table, 5, axis=1))
    assert score_gram(copied) == pytest.approx(score_gram(one), rel=1e-3, abs=1e-3)
