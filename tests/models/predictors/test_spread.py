"""A spread learns how far forecasts are off, and in which direction."""

import numpy as np
import pytest

from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.protocol import History
from rallygap.models.predictors.spread_training import fit_spread
from tests.models.predictors.balls import FIRST, observed
from tests.models.predictors.small_training import network, small_training, tracks


@pytest.fixture(scope="module")
def learned():
    trained = small_training()[0].network
    before = {name: value.clone() for name, value in trained.state_dict().items()}
    predictor = LearnedPredictor(trained, fit_spread(trained, tracks(30, 0), seed=0))
    # The network stays as it is.
    assert all(value.equal(before[name]) for name, value in trained.state_dict().items())
    return predictor


def test_sizes_are_those_of_the_errors(learned):
    """After a short training, to a factor."""
    history, future = observed(np.tile(FIRST, (40, 1)), noise=0.003, seed=3)
    errors = (learned.predict(history).states - future)[..., :3]
    found = np.sqrt(np.diagonal(learned.predict_with_covariances(history)[1], axis1=2, axis2=3))
    ratio = np.median(np.abs(errors), axis=(0, 1)) / (0.6745 * np.median(found, axis=(0, 1)))
    assert (ratio > 0.3).all() and (ratio < 3.0).all()


def test_covariances_are_positive_and_turn_with_the_direction_of_play(learned):
    history, _ = observed(noise=0.003)
    half = np.tile([-1.0, -1.0, 1.0], 2)
    found = learned.predict_with_covariances(history)[1]
    turned = learned.predict_with_covariances(History(history.states * half, history.mask))[1]
    assert turned == pytest.approx(found * np.outer(half[:3], half[:3]), rel=1e-4, abs=1e-9)
    assert found == pytest.approx(np.swapaxes(found, 2, 3))
    assert (np.linalg.eigvalsh(found) > 0).all()


def test_without_a_spread_there_are_no_covariances():
    history, _ = observed()
    with pytest.raises(ValueError, match="no spread"):
        LearnedPredictor(network()).predict_with_covariances(history)
