"""The contract of every predictor."""

import numpy as np
import pytest

from experiments.ensemble import EnsemblePredictor
from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import FUTURE, History
from tests.models.predictors.balls import observed
from tests.models.predictors.small_training import NETWORKS, network, small_training

PREDICTORS = {
    "physics": PhysicsPredictor(shipped("imperfect_c")),
    # The contract asks for no training.
    **{kind: LearnedPredictor(network(settings)) for kind, settings in NETWORKS.items()},
}
# Single precision sums in an order that depends on the batch.
ROUNDING = {"physics": 1e-9, **dict.fromkeys(NETWORKS, 1e-4)}


@pytest.mark.parametrize("name", PREDICTORS)
@pytest.mark.parametrize("seen", [0, 1, 2, 5, 12])
def test_a_ball_however_seldom_seen_gets_sixty_finite_states(name, seen):
    history, _ = observed(noise=0.003)
    mask = history.mask.copy()
    mask[:, seen:] = False
    forecast = PREDICTORS[name].predict(History(np.where(mask, history.states, 0.0), mask))
    assert forecast.states.shape == (len(history), FUTURE, 9)
    assert np.isfinite(forecast.states).all()
    assert forecast.spin_measured.tolist() == [seen > 0] * len(history)


def test_a_spin_counts_as_measured_when_one_sample_has_all_of_it():
    history, _ = observed()
    mask = history.mask.copy()
    mask[0, 1:, 3:] = False  # one label
    mask[1, :, 5] = False  # never whole
    mask[2, :, 3:] = False  # none
    assert History(history.states * mask, mask).spin_measured.tolist() == [True, False, False]


@pytest.mark.parametrize("name", PREDICTORS)
def test_a_ball_does_not_depend_on_its_batch(name):
    predictor, rounding = PREDICTORS[name], ROUNDING[name]
    history, _ = observed(noise=0.003)
    together = predictor.predict(history).states
    assert predictor.predict(history[:0]).states.shape == (0, FUTURE, 9)
    for ball in range(len(history)):
        alone = predictor.predict(history[ball : ball + 1]).states[0]
        np.testing.assert_allclose(alone, together[ball], rtol=rounding, atol=rounding)


@pytest.mark.parametrize(
    ("states", "mask"),
    [
        (np.zeros((2, 11, 6)), np.ones((2, 11, 6), dtype=bool)),
        (np.full((1, 12, 6), np.nan), np.ones((1, 12, 6), dtype=bool)),
        (np.ones((1, 12, 6)), np.zeros((1, 12, 6), dtype=bool)),
    ],
)
def test_a_history_that_is_none_is_refused(states, mask):
    with pytest.raises(ValueError, match="a history is"):
        History(states, mask)


def test_a_network_forecasts_the_same_for_either_direction_of_play():
    history, _ = observed(noise=0.003)
    predictor = LearnedPredictor(small_training()[0].network)
    half_turn = np.array([-1, -1, 1])
    twin = History(history.states * np.tile(half_turn, 2), history.mask)
    forecast, rotated = (predictor.predict(one).states for one in (history, twin))
    np.testing.assert_array_equal(rotated, forecast * np.tile(half_turn, 3))
    assert (forecast[:, 0, 4] < 0).all() and (rotated[:, 0, 4] > 0).all()


def test_an_ensemble_forecasts_the_mean_and_is_as_unsure_as_a_random_member():
    members = [PhysicsPredictor(shipped(name)) for name in ("literature", "imperfect_c")]
    history, _ = observed(noise=0.003)
    ensemble = EnsemblePredictor(members)
    forecast, covariances = ensemble.predict_with_covariances(history)
    alone, own = zip(*(one.predict_with_covariances(history) for one in members), strict=True)
    states = [one.states for one in alone]
    np.testing.assert_allclose(forecast.states, np.mean(states, axis=0))
    np.testing.assert_allclose(ensemble.predict(history).states, forecast.states)
    half = (states[0] - states[1])[..., :3] / 2
    between = half[..., None] * half[..., None, :]
    np.testing.assert_allclose(covariances, np.mean(own, axis=0) + between, atol=1e-12)
