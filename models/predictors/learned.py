"""Learned predictors: a network with its normaliser, behind the predictor protocol."""

import numpy as np
import torch
from torch import Tensor, nn

from rallygap.models.ball.simulator import Simulator
from rallygap.models.predictors.autoencoders import RecurrentAutoencoder, TrajectoryAutoencoder
from rallygap.models.predictors.normaliser import Normaliser, uniform_motion
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import Floats, Forecast, History
from rallygap.models.predictors.settings import (
    GruTaeSettings,
    HybridSettings,
    NetworkSettings,
    TaeSettings,
)
from rallygap.models.predictors.spread import Spread
from rallygap.models.predictors.transformer import Transformer


class ForecastNetwork(nn.Module):
    """A network that maps normalised histories to normalised futures, with its normaliser.

    It corrects a baseline: uniform motion, or the forecast of a simulator (a hybrid).

    Args:
        network: maps four normalised tensors to (B, 60, 9) deviations from the baseline:
            history: (B, 12, 6) measurements, zero where there are none;
            mask: (B, 12, 6) where there are;
            residual: (B, 12, 3) deviations of measured positions from the baseline's straight line;
            expected: (B, 60, 6) positions and spins of the baseline.
        physics: whose forecasts a hybrid corrects.
    """

    def __init__(self, network: nn.Module, physics: PhysicsPredictor | None = None) -> None:
        super().__init__()
        self.normaliser, self.network, self.physics = Normaliser(), network, physics

    @property
    def simulator(self) -> Simulator | None:
        """The simulator of a hybrid."""
        return self.physics.simulator if self.physics else None

    def baseline(self, history: Tensor, mask: Tensor) -> Tensor:
        """Return the (B, 60, 9) ball states that the network corrects."""
        if self.physics is None:
            return uniform_motion(history, mask)
        measured = torch.where(mask, history, 0.0).cpu().numpy().astype(np.float64)
        seen = History(measured, mask.cpu().numpy())
        states = self.physics.predict(seen).states
        return torch.as_tensor(states, dtype=history.dtype, device=history.device)

    def forward(self, history: Tensor, mask: Tensor) -> Tensor:
        """Return (B, 60, 9) ball states.

        Args:
            history: (B, 12, 6) measured positions (m) and spins (rad/s), zero where not measured.
            mask: (B, 12, 6) where they were measured.
        """
        return self.corrected(history, mask, self.baseline(history, mask))

    def corrected(self, history: Tensor, mask: Tensor, motion: Tensor) -> Tensor:
        """Return (B, 60, 9) ball states: those of the baseline, corrected."""
        return self.normaliser.states(self.deviation(history, mask, motion), motion)

    def factors(self, spread: Spread, history: Tensor, mask: Tensor, motion: Tensor) -> Tensor:
        """Return (B, 60, 3, 3) factors A, m, of the covariances A'A of the states' positions."""
        rows = spread(*self.inputs(history, mask, motion)).mT
        return self.normaliser.distances(rows.flatten(1, 2), motion).view(rows.shape)

    def deviation(self, history: Tensor, mask: Tensor, motion: Tensor) -> Tensor:
        """Return the (B, 60, 9) normalised deviations from the baseline, which training fits."""
        inputs = self.inputs(history, mask, motion)
        return self.network(*inputs, self.normaliser.expected(motion))

    def inputs(self, history: Tensor, mask: Tensor, motion: Tensor) -> tuple[Tensor, ...]:
        """Return the first three inputs of the network, which are those of a spread."""
        normaliser = self.normaliser
        normalised = normaliser.normalised(history, mask, motion)
        return normalised, mask, normaliser.residual(history, mask, motion)

    @property
    def parameter_count(self) -> int:
        """Number of trained parameters."""
        return sum(parameter.numel() for parameter in self.parameters())


def build_network(settings: NetworkSettings, simulator: Simulator | None = None) -> ForecastNetwork:
    """Return an untrained network, its weights drawn from torch's generator.

    Args:
        settings: of the network.
        simulator: that its settings name, if it is a hybrid.
    """
    sizes = settings.model_dump(exclude={"kind", "simulator"})
    if isinstance(settings, TaeSettings):
        return ForecastNetwork(TrajectoryAutoencoder(**sizes))
    if isinstance(settings, GruTaeSettings):
        return ForecastNetwork(RecurrentAutoencoder(**sizes))
    transformer = Transformer(**sizes)
    if not isinstance(settings, HybridSettings):
        return ForecastNetwork(transformer)
    transformer.start_at_baseline()
    return ForecastNetwork(transformer, PhysicsPredictor(simulator) if simulator else None)


class LearnedPredictor:
    """A trained network as a predictor; it stays where the network is, on CPU or GPU.

    Args:
        network: forecasts.
        spread: of its errors; without one there are no covariances.
    """

    def __init__(self, network: ForecastNetwork, spread: Spread | None = None) -> None:
        self.network, self.spread = network.eval(), spread

    def predict(self, history: History) -> Forecast:
        """Forecast each ball."""
        with torch.inference_mode():
            forecast = self.network(*self._tensors(history))
        return Forecast(_array(forecast), history.spin_measured)

    def predict_with_covariances(self, history: History) -> tuple[Forecast, Floats]:
        """Forecast each ball, with (B, 60, 3, 3) covariances of positions, m^2.

        Raises:
            ValueError: there is no spread.
        """
        if self.spread is None:
            raise ValueError("this predictor has no spread, so it does not know its errors")
        states, mask = self._tensors(history)
        with torch.inference_mode():
            motion = self.network.baseline(states, mask)
            forecast = self.network.corrected(states, mask, motion)
            factors = _array(self.network.factors(self.spread, states, mask, motion))
        covariances = np.swapaxes(factors, 2, 3) @ factors
        return Forecast(_array(forecast), history.spin_measured), covariances

    def _tensors(self, history: History) -> tuple[Tensor, Tensor]:
        device = self.network.normaliser.future_mean.device
        states = torch.as_tensor(history.states, dtype=torch.float32, device=device)
        return states, torch.as_tensor(history.mask, device=device)


def _array(values: Tensor) -> Floats:
    return values.cpu().numpy().astype(np.float64)
