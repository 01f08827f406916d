"""Landing: where and when balls first touch the table, as a sensor measures it."""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.sensor import clock_times, delays, measured_positions
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.trajectory import first_bounce

ON_TABLE = slice(0, 2)  # components of a place


@dataclass(frozen=True)
class Landings:
    """First bounces of B balls, NaN for those that never bounce.

    Attributes:
        places: (B, 2) m, across the table and along it.
        times: (B,) s from the first sample.
    """

    places: Floats
    times: Floats

    def distances(self, others: "Landings") -> Floats:
        """Return (B, 2) m and s, how far landings are from others."""
        places = np.linalg.norm(self.places - others.places, axis=1)
        return np.stack([places, np.abs(self.times - others.times)], axis=1)


def landings(simulator: Simulator, states: Floats, ends: Floats) -> Landings:
    """Return where and when balls of (B, 9) states land within (B,) s, as the sensor sees it."""
    flight = simulator.fly(states, np.stack([np.zeros(len(ends)), ends], axis=1))
    there, time, before, _ = first_bounce(flight)
    speed = np.linalg.norm(before[:, VELOCITY], axis=1)
    places, times = np.full((len(states), 2), np.nan), np.full(len(states), np.nan)
    places[there] = measured_positions(simulator, before[:, POSITION])[:, ON_TABLE]
    times[there] = clock_times(simulator, time + delays(simulator, speed))
    return Landings(places, times)
