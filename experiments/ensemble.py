"""Ensembles: the mean of several predictors (Dietterich 2000)."""

from collections.abc import Sequence

import numpy as np

from rallygap.models.ball.state import POSITION
from rallygap.models.predictors.protocol import Floats, Forecast, History, ProbabilisticPredictor


class EnsemblePredictor:
    """Forecasts the mean of what its members forecast.

    Args:
        members: one or more.
    """

    def __init__(self, members: Sequence[ProbabilisticPredictor]) -> None:
        self.members = tuple(members)

    def predict(self, history: History) -> Forecast:
        """Forecast each ball."""
        return _mean([member.predict(history) for member in self.members])

    def predict_with_covariances(self, history: History) -> tuple[Forecast, Floats]:
        """Forecast each ball; the (B, 60, 3, 3) covariances, m^2, are those of the mixture.

        The mean of the members' covariances, and the covariance between the members.
        """
        forecasts = [member.predict_with_covariances(history) for member in self.members]
        mean = _mean([forecast for forecast, _ in forecasts])
        within = np.mean([covariances for _, covariances in forecasts], axis=0)
        apart = [(forecast.states - mean.states)[..., POSITION] for forecast, _ in forecasts]
        between = np.mean([away[..., :, None] * away[..., None, :] for away in apart], axis=0)
        return mean, within + between


def _mean(forecasts: Sequence[Forecast]) -> Forecast:
    states = np.mean([forecast.states for forecast in forecasts], axis=0)
    return Forecast(states, forecasts[0].spin_measured)
