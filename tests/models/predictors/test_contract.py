"""The contract of every predictor."""

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import FUTURE, History
from tests.models.predictors.balls import observed
from tests.models.predictors.small_training import NETWORKS, network

PREDICTORS = {
    "physics": PhysicsPredictor(shipped("imperfect_c")),
    # The contract asks for no training.
    **{kind: LearnedPredictor(network(settings)) for kind, settings in NETWORKS.items()},
}
# Single precision sums in an order that depends on the batch.
ROUNDING = {"physics": 1e-9, **dict.fromkeys(NETWORKS, 1e-4)}


@pytest.fixture(params=PREDICTORS, ids=list(PREDICTORS))
def predictor(request):
    return PREDICTORS[request.param]


def test_a_forecast_has_sixty_finite_states_a_ball(predictor):
    history, _ = observed(noise=0.003)
    forecast = predictor.predict(history)
    assert forecast.states.shape == (len(history), FUTURE, 9)
    assert np.isfinite(forecast.states).all()
    assert forecast.spin_measured.tolist() == [True] * len(history)


def test_a_missing_label_is_reported(predictor):
    history, _ = observed(labelled=False)
    assert not predictor.predict(history).spin_measured.any()


@pytest.mark.parametrize("seen", [0, 1, 2, 5])
def test_a_ball_hardly_seen_still_gets_a_finite_forecast(predictor, seen):
    history, _ = observed()
    mask = history.mask.copy()
    mask[:, seen:] = False
    sparse = History(np.where(mask, history.states, 0.0), mask)
    assert np.isfinite(predictor.predict(sparse).states).all()


@pytest.mark.parametrize("name", PREDICTORS)
def test_a_ball_does_not_depend_on_its_batch(name):
    predictor, rounding = PREDICTORS[name], ROUNDING[name]
    history, _ = observed(noise=0.003)
    together = predictor.predict(history).states
    for ball in range(len(history)):
        alone = predictor.predict(history[ball : ball + 1]).states[0]
        np.testing.assert_allclose(alone, together[ball], rtol=rounding, atol=rounding)


def test_an_empty_batch_gives_an_empty_forecast(predictor):
    empty = History(np.zeros((0, 12, 6)), np.zeros((0, 12, 6), dtype=bool))
    assert predictor.predict(empty).states.shape == (0, FUTURE, 9)


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
