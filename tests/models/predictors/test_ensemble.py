"""An ensemble forecasts the mean, and is as unsure as the mixture of its members."""

import numpy as np

from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.ensemble import EnsemblePredictor
from rallygap.models.predictors.physics import PhysicsPredictor
from tests.models.predictors.balls import observed

MEMBERS = [PhysicsPredictor(shipped(name)) for name in ("literature", "imperfect_c")]


def test_it_forecasts_the_mean():
    history, _ = observed(noise=0.003)
    found = EnsemblePredictor(MEMBERS).predict(history)
    alone = [one.predict(history).states for one in MEMBERS]
    np.testing.assert_allclose(found.states, (alone[0] + alone[1]) / 2)


def test_its_covariance_is_that_of_draws_from_a_random_member():
    history, _ = observed(noise=0.003)
    forecast, covariances = EnsemblePredictor(MEMBERS).predict_with_covariances(history)
    random, last = np.random.default_rng(0), (0, -1)
    draws = []
    for member in MEMBERS:
        one, own = member.predict_with_covariances(history)
        draws.append(random.multivariate_normal(one.states[last][:3], own[last], 200_000))
    np.testing.assert_allclose(
        np.cov(np.concatenate(draws).T), covariances[last], rtol=0.05, atol=2e-6
    )
    np.testing.assert_allclose(forecast.states, EnsemblePredictor(MEMBERS).predict(history).states)
