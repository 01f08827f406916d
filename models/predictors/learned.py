"""A learned predictor: a network between a normaliser's two halves, behind the protocol."""

import numpy as np
import torch
from torch import Tensor, nn

from models.predictors.normaliser import Normaliser
from models.predictors.protocol import Forecast, History
from models.predictors.settings import TransformerSettings
from models.predictors.transformer import Transformer


class ForecastNetwork(nn.Module):
    """A network that maps normalised histories to normalised futures, with its normaliser.

    Args:
        network: (B, 12, 6) -> (B, 60, 9).
    """

    def __init__(self, network: nn.Module) -> None:
        super().__init__()
        self.normaliser, self.network = Normaliser(), network

    def forward(self, history: Tensor, seen: Tensor) -> Tensor:
        """Return (B, 60, 9) ball states.

        Args:
            history: (B, 12, 6) measured positions (m) and spins (rad/s), zero where not measured.
            seen: (B, 12, 6) where they were measured.
        """
        return self.normaliser.states(self.deviation(history, seen), history, seen)

    def deviation(self, history: Tensor, seen: Tensor) -> Tensor:
        """Return the (B, 60, 9) normalised deviations from uniform motion, which training fits."""
        normalised = self.normaliser.normalised(history, seen)
        deviation: Tensor = self.network(normalised, self.normaliser.expected(history, seen))
        return deviation

    @property
    def parameter_count(self) -> int:
        """How many numbers were trained."""
        return sum(parameter.numel() for parameter in self.parameters())


def build_network(settings: TransformerSettings) -> ForecastNetwork:
    """Return an untrained network, its weights drawn from torch's generator."""
    return ForecastNetwork(
        Transformer(
            settings.width,
            settings.expanded,
            settings.heads,
            settings.encoder_layers,
            settings.decoder_layers,
            settings.states_a_row,
            settings.placeholders,
        )
    )


class LearnedPredictor:
    """A trained network as a predictor; it stays where the network is, on CPU or GPU."""

    def __init__(self, network: ForecastNetwork) -> None:
        self.network = network.eval()

    def predict(self, history: History) -> Forecast:
        """Forecast each ball."""
        device = self.network.normaliser.future_mean.device
        states = torch.as_tensor(history.states, dtype=torch.float32, device=device)
        seen = torch.as_tensor(history.mask, device=device)
        with torch.inference_mode():
            forecast = self.network(states, seen)
        labelled = np.any(history.mask[:, :, 3:].all(axis=2), axis=1)
        return Forecast(forecast.cpu().numpy().astype(np.float64), labelled)
