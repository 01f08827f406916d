"""A hybrid corrects a simulator's forecast, and at first leaves it as it is."""

import numpy as np
import pytest
import torch

from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.learned import LearnedPredictor, build_network
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import History
from rallygap.models.predictors.training import ForecastTraining
from tests.models.predictors.balls import FIRST, observed
from tests.models.predictors.small_training import BRIEF, TINY_HYBRID, changed, data, fit

WRONG = shipped("imperfect_c_with_net")


@pytest.fixture
def untrained(monkeypatch):
    """An untrained hybrid of the wrong simulator, fitted to few windows: its filter is slow."""
    monkeypatch.setattr("rallygap.models.predictors.training.LARGEST_FIT", 300)
    torch.manual_seed(0)
    network = build_network(TINY_HYBRID, WRONG)
    data().fit_normaliser(network)
    network.normaliser.future_mean.zero_()
    return network


def test_an_untrained_hybrid_forecasts_as_its_simulator_from_what_is_measured(untrained):
    history, _ = observed(noise=0.003)
    mask = history.mask.copy()
    mask[1, :, 3:] = False
    hidden = History(np.where(mask, history.states, 0.0), mask)
    expected = PhysicsPredictor(WRONG).predict(hidden).states
    found = LearnedPredictor(untrained).predict(hidden).states
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-3)


def test_training_removes_what_the_simulator_has_wrong(untrained):
    settings = changed(BRIEF, epochs=12, learning_rate=0.01, decay=0.8)
    fit(ForecastTraining(untrained, settings), data(settings), accelerator="cpu")
    history, future = observed(np.tile(FIRST, (20, 1)), noise=0.003, seed=9)
    misses = [
        np.median(np.linalg.norm((one.predict(history).states - future)[:, -1, :3], axis=1))
        for one in (LearnedPredictor(untrained), PhysicsPredictor(WRONG))
    ]
    assert misses[0] < 0.6 * misses[1]
