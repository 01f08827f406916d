"""The forecast of a ball after a frame, in numbers."""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.state import POSITION
from rallygap.models.ball.types import Floats
from rallygap.models.live.forecaster import Event, Forecaster

AHEAD = 0.01 * np.arange(1, 31)  # s after the last measurement, of the states in a forecast


@dataclass(frozen=True)
class BallForecast:
    """Where a ball will be.

    Attributes:
        time: s, of its last measurement, on the sensor's clock.
        states: (30, 9) position (m), velocity (m/s) and spin (rad/s), ``AHEAD`` of that time.
        covariances: (30, 3, 3) m^2, of the positions.
        bounce: the next contact with the table; None without any.
    """

    time: float
    states: Floats
    covariances: Floats
    bounce: Event | None


def ball_forecast(forecaster: Forecaster) -> BallForecast | None:
    """Return the forecast of the present ball; None without a ball."""
    if not forecaster.ready:
        return None
    states, covariances = forecaster.predict(forecaster.last + AHEAD)
    of_positions = covariances[:, POSITION, POSITION]
    return BallForecast(forecaster.last, states, of_positions, forecaster.bounce())
