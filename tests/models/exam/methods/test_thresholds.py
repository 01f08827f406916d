"""Thresholds: chosen where clean sets stay clean and hidden effects are found."""

import numpy as np

from models.exam.methods.regression import Regression
from models.exam.methods.thresholds import accuracy, best_threshold, with_hidden
from models.gap.hypotheses import Hypothesis

COLUMNS = (Hypothesis("wind", "x"), Hypothesis("wind", "y"), Hypothesis("drag", "cd"))


def strongest(regression, threshold):
    return tuple(np.flatnonzero(np.abs(regression.estimates((0, 1, 2))) > threshold).tolist())


def regression(*values):
    gram = np.diag([100.0, 100.0, 100.0, 0.0])
    gram[:3, 3] = gram[3, :3] = 100.0 * np.array(values)
    return Regression.of(COLUMNS, gram[None])


CLEAN = [(regression(0.2, 0.1, 0.0), None), (regression(0.0, 0.0, 0.5), None)]
HIDDEN = [(regression(0.2, 0.1, 0.9), "drag"), (regression(0.7, 0.0, 0.3), "wind")]


def test_accuracy_is_the_mean_over_clean_and_hidden_sets():
    assert accuracy(strongest, CLEAN + HIDDEN, 0.4) == (1 / 2 + 1) / 2
    assert accuracy(strongest, CLEAN + HIDDEN, 0.8) == (1 + 1 / 2) / 2


def test_the_best_threshold_lies_between_noise_and_effects():
    assert best_threshold(strongest, CLEAN + HIDDEN, [0.1, 0.4, 0.6, 0.8]) == 0.6


def test_a_hidden_effect_is_what_the_residuals_would_have_of_it():
    rows = np.random.default_rng(0).standard_normal((5, 30, 4))
    hidden = rows.copy()
    hidden[..., 3] += 0.7 * rows[..., 1]
    grams = np.swapaxes(rows, 1, 2) @ rows
    expected = np.swapaxes(hidden, 1, 2) @ hidden
    assert np.allclose(with_hidden(grams, 1, 0.7), expected)
