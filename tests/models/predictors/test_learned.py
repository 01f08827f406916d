"""A network behind the predictors' protocol."""

import numpy as np
import torch

from rallygap.models.predictors.learned import ForecastNetwork, LearnedPredictor
from rallygap.models.predictors.normaliser import uniform_motion
from rallygap.models.predictors.protocol import History
from tests.models.predictors.balls import observed
from tests.models.predictors.small_training import network, small_training


class Constant(torch.nn.Module):
    """A network with a constant output that stores its inputs."""

    def __init__(self, output):
        super().__init__()
        self.output = output

    def forward(self, history, seen, residual, expected):
        self.inputs, self.mask, self.residual, self.expected = history, seen, residual, expected
        return torch.full((len(history), 60, 9), self.output)


def fitted(inner):
    """``inner`` between the halves of a normaliser that was fitted to balls."""
    outer = ForecastNetwork(inner)
    training, _ = small_training()
    outer.normaliser.load_state_dict(training.network.normaliser.state_dict())
    return outer


def test_forecast_is_uniform_motion_plus_network_output():
    history, _ = observed(noise=0.003)
    predictor = LearnedPredictor(fitted(Constant(2.0)))
    normaliser = predictor.network.normaliser
    motion = uniform_motion(torch.from_numpy(history.states), torch.from_numpy(history.mask))
    expected = motion + normaliser.future_mean + 2.0 * normaliser.future_spread
    np.testing.assert_allclose(
        predictor.predict(history).states, expected, rtol=1e-5, atol=1e-4
    )  # fmt: skip


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
