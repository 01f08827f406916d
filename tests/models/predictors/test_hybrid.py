"""A hybrid corrects a simulator's forecast, and at first leaves it as it is."""

import lightning
import numpy as np
import pytest
import torch

from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.learned import LearnedPredictor, build_network
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import History
from rallygap.models.predictors.training import ForecastTraining
from tests.models.predictors.balls import FIRST, TRUTH, observed
from tests.models.predictors.small_training import BRIEF, TINY_HYBRID, changed, data

WRONG = shipped("imperfect_c_with_net")


def untrained(simulator):
    torch.manual_seed(0)
    network = build_network(TINY_HYBRID, simulator)
    data().fit_normaliser(network)
    network.normaliser.future_mean.zero_()
    return network


def miss(predictor, history, future):
    away = (predictor.predict(history).states - future)[..., :3]
    return np.median(np.linalg.norm(away, axis=2)[:, -1])


def test_an_untrained_hybrid_forecasts_as_its_simulator():
    history, _ = observed(noise=0.003)
    for simulator in (WRONG, TRUTH):
        expected = PhysicsPredictor(simulator).predict(history).states
        found = LearnedPredictor(untrained(simulator)).predict(history).states
        np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-3)


def test_training_removes_what_the_simulator_has_wrong():
    network = untrained(WRONG)
    settings = changed(BRIEF, epochs=12, learning_rate=0.01, decay=0.8)
    trainer = lightning.Trainer(
        max_epochs=12, logger=False, enable_progress_bar=False, enable_model_summary=False,
        enable_checkpointing=False, accelerator="cpu", reload_dataloaders_every_n_epochs=1,
    )  # fmt: skip
    trainer.fit(ForecastTraining(network, settings), data(settings))
    history, future = observed(np.tile(FIRST, (20, 1)), noise=0.003, seed=9)
    hybrid = miss(LearnedPredictor(network), history, future)
    assert hybrid < 0.6 * miss(PhysicsPredictor(WRONG), history, future)


def test_what_is_not_measured_does_not_matter():
    network = untrained(WRONG)
    history, _ = observed(noise=0.003)
    mask = history.mask.copy()
    mask[:, :, 3:] = False
    hidden = History(np.where(mask, history.states, 0.0), mask)
    states = torch.as_tensor(history.states, dtype=torch.float32)
    found = network.baseline(states, torch.as_tensor(mask)).numpy()
    expected = PhysicsPredictor(WRONG).predict(hidden).states
    assert found == pytest.approx(expected, rel=1e-4, abs=1e-3)
