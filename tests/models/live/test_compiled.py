"""A compiled network forecasts what torch does, and in a forecaster as any predictor."""

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


@pytest.fixture(scope="module", params=list(NETWORKS))
def learned(request):
    torch.manual_seed(0)
    simulator = TRUTH if request.param == "hybrid" else None
    untrained = build_network(NETWORKS[request.param], simulator)
    untrained.normaliser.future_spread.fill_(0.3)
    return LearnedPredictor(untrained, Spread())


def thrown(forecaster):
    for k in range(12):
        forecaster.observe(0.005 * k, [0.0, 1.0 - 0.03 * k, 0.3])
    return forecaster


def test_forecasts_and_covariances_are_those_of_torch(learned):
    compiled = CompiledPredictor(learned)
    history, _ = observed(noise=0.003)
    for k in range(3):
        forecast, covariances = compiled.predict_with_covariances(history[k : k + 1])
        expected, spread = learned.predict_with_covariances(history[k : k + 1])
        np.testing.assert_allclose(forecast.states, expected.states, atol=2e-4)
        np.testing.assert_allclose(covariances, spread, atol=1e-4 * spread.max())
        assert forecast.spin_measured == expected.spin_measured


def test_a_forecaster_takes_it(learned):
    forecaster = thrown(Forecaster(TRUTH, CompiledPredictor(learned)))
    states, covariances = forecaster.predict(forecaster.last + np.array([0.1, 0.2]))
    assert np.isfinite(states).all() and np.isfinite(covariances).all()


def test_between_two_horizons_forecasts_are_those_of_all(learned):
    asked = np.array([0.1149, 0.12, 0.1251])
    found = []
    for compiled in (CompiledPredictor(learned), CompiledPredictor(learned, (0.115, 0.125))):
        forecaster = thrown(Forecaster(TRUTH, compiled))
        found.append(forecaster.predict(forecaster.last + asked))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, atol=2e-4 * np.abs(one).max())


def test_other_horizons_are_refused():
    torch.manual_seed(0)
    learned = LearnedPredictor(build_network(NETWORKS["transformer"]), Spread())
    forecaster = thrown(Forecaster(TRUTH, CompiledPredictor(learned, (0.115, 0.125))))
    for ask in (lambda: forecaster.predict([forecaster.last + 0.2]), forecaster.bounce):
        with pytest.raises(ValueError, match="compiled"):
            ask()


def test_without_a_spread_nothing_is_compiled(learned):
    with pytest.raises(ValueError, match="no spread"):
        CompiledPredictor(LearnedPredictor(learned.network))


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
