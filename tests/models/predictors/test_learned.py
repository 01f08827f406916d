"""A network behind the predictors' protocol."""

import numpy as np

from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.protocol import History
from tests.models.predictors.balls import observed
from tests.models.predictors.small_training import network, small_training


def test_forecast_is_equivariant_under_a_half_turn():
    history, _ = observed(noise=0.003)
    predictor = LearnedPredictor(small_training()[0].network)
    half_turn = np.array([-1, -1, 1])
    twin = History(history.states * np.tile(half_turn, 2), history.mask)
    forecast, rotated = (predictor.predict(one).states for one in (history, twin))
    np.testing.assert_array_equal(rotated, forecast * np.tile(half_turn, 3))
    assert (forecast[:, 0, 4] < 0).all() and (rotated[:, 0, 4] > 0).all()


def test_a_spin_counts_as_measured_when_one_sample_has_all_of_it():
    history, _ = observed()
    mask = history.mask.copy()
    mask[0, 1:, 3:] = False  # one label
    mask[1, :, 5] = False  # never whole
    mask[2, :, 3:] = False  # none
    forecast = LearnedPredictor(network()).predict(History(history.states * mask, mask))
    assert forecast.spin_measured.tolist() == [True, False, False]
