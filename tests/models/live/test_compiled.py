"""A compiled network forecasts what torch does, and in a forecaster as any predictor."""

from functools import cache

import numpy as np
import pytest
import torch

from rallygap.models.live.compiled import CompiledPredictor
from rallygap.models.live.forecaster import Forecaster
from rallygap.models.predictors.learned import LearnedPredictor, build_network
from rallygap.models.predictors.settings import HybridSettings, TaeSettings, TransformerSettings
from rallygap.models.predictors.spread import Spread
from tests.models.predictors.balls import TRUTH, observed
from tests.models.predictors.small_training import data, network

SIZES = {"width": 16, "expanded": 16, "heads": 2, "encoder_layers": 1, "decoder_layers": 2}
ROWS = {"states_per_row": 10, "uniform_motion": True}
NETWORKS = {
    "transformer": TransformerSettings(kind="transformer", **SIZES, **ROWS),
    "transformer of single rows": TransformerSettings(
        kind="transformer", **SIZES, states_per_row=1, uniform_motion=False
    ),
    "hybrid": HybridSettings(kind="hybrid", simulator="imperfect_c_with_net", **SIZES, **ROWS),
    "tae": TaeSettings(
        kind="tae", hidden=16, features=8, latent=8, decoded=16, uniform_motion=False
    ),
}


@cache
def learned(name):
    torch.manual_seed(0)
    untrained = build_network(NETWORKS[name], TRUTH if name == "hybrid" else None)
    untrained.normaliser.future_spread.fill_(0.3)
    return LearnedPredictor(untrained, Spread())


@cache
def compiled(name):
    return CompiledPredictor(learned(name))


def thrown(predictor):
    forecaster = Forecaster(TRUTH, predictor)
    for k in range(12):
        forecaster.observe(0.005 * k, [0.0, 1.0 - 0.03 * k, 0.3])
    return forecaster


@pytest.mark.parametrize("name", NETWORKS)
def test_forecasts_and_covariances_are_those_of_torch(name):
    history, _ = observed(noise=0.003)
    for k in range(3):
        forecast, covariances = compiled(name).predict_with_covariances(history[k : k + 1])
        expected, spread = learned(name).predict_with_covariances(history[k : k + 1])
        np.testing.assert_allclose(forecast.states, expected.states, atol=2e-4)
        np.testing.assert_allclose(covariances, spread, atol=1e-4 * spread.max())
        assert forecast.spin_measured == expected.spin_measured
    forecaster = thrown(compiled(name))
    states, covariances = forecaster.predict(forecaster.last + np.array([0.1, 0.2]))
    assert np.isfinite(states).all() and np.isfinite(covariances).all()


@pytest.mark.parametrize("name", ["transformer", "transformer of single rows"])
def test_between_two_horizons_forecasts_are_those_of_all_and_others_are_refused(name):
    whole, part = thrown(compiled(name)), thrown(CompiledPredictor(learned(name), (0.115, 0.125)))
    asked = whole.last + np.array([0.1149, 0.12, 0.1251])
    for one, other in zip(whole.predict(asked), part.predict(asked), strict=True):
        np.testing.assert_allclose(one, other, atol=2e-4 * np.abs(one).max())
    for ask in (lambda: part.predict([part.last + 0.2]), part.bounce):
        with pytest.raises(ValueError, match="compiled"):
            ask()


def test_without_a_spread_nothing_is_compiled():
    with pytest.raises(ValueError, match="no spread"):
        CompiledPredictor(LearnedPredictor(learned("tae").network))


def test_a_large_transformer_changes_by_less_than_a_millimetre():
    sizes = {"width": 512, "expanded": 1024, "heads": 8, "encoder_layers": 3, "decoder_layers": 2}
    settings = TransformerSettings(
        kind="transformer", **sizes, states_per_row=1, uniform_motion=False
    )
    untrained = network(settings)
    data().fit_normaliser(untrained)
    learned = LearnedPredictor(untrained, Spread())
    history, _ = observed(noise=0.003)
    found = CompiledPredictor(learned).predict(history[:1]).states
    change = np.linalg.norm((found - learned.predict(history[:1]).states)[..., :3], axis=-1)
    assert 1e-5 < change.max() < 1e-3  # m; integers serve, so it is not zero
