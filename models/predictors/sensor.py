"""The sensor of a simulator: true balls behind measurements, and forecasts as it measures them.

An amended simulator may have effects of the sensor: cameras that err as a function of place, a
tilted frame, a clock that runs fast. Forecasts are in the coordinates of the measurements, so what
is measured is corrected, flown, and distorted again.
"""

from functools import cached_property

import numpy as np

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.sensor import measured_positions, measured_spins, sensor_quantity
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.predictors.protocol import History

STEPS = 3  # of a fixed-point iteration; sensors err by millimetres that hardly vary over as much
MOMENT = 1e-3  # s, over which a velocity is measured


class Sensor:
    """The systematic errors of a simulator's sensor, but for delays.

    Args:
        simulator: with effects of the sensor, or without.
    """

    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator

    @cached_property
    def exact(self) -> bool:
        """Whether there are none."""
        return not any(catalogue()[name].acts == "sensor" for name in self.simulator.effects)

    @cached_property
    def clock(self) -> float:
        """Seconds on the sensor's clock in a true second."""
        return 1.0 if self.exact else float(sensor_quantity(self.simulator, "clock_gain"))

    def true_positions(self, measured: Floats) -> Floats:
        """Return (..., 3) true positions, m, of measured ones."""
        true = measured
        for _ in range(0 if self.exact else STEPS):
            true = true + measured - measured_positions(self.simulator, true)
        return true

    @cached_property
    def _labels(self) -> Floats:
        """(3, 3) labels of the three unit spins: errors of labels are linear."""
        return measured_spins(self.simulator, np.eye(3))

    def true_spins(self, labels: Floats) -> Floats:
        """Return (..., 3) true spins, rad/s, of labels."""
        if self.exact:
            return labels
        return labels @ np.linalg.inv(self._labels)

    def true_history(self, history: History) -> History:
        """Return a history of true positions and spins."""
        if self.exact:
            return history
        positions, labels = history.states[..., :3], history.states[..., 3:]
        true = np.concatenate([self.true_positions(positions), self.true_spins(labels)], axis=-1)
        return History(np.where(history.mask, true, 0.0), history.mask)

    def measured_states(self, states: Floats) -> Floats:
        """Return (..., 9) states as the sensor would measure them."""
        if self.exact:
            return states
        positions = states[..., POSITION]
        both = np.stack([positions, positions + MOMENT * states[..., VELOCITY]])
        now, ahead = measured_positions(self.simulator, both)
        velocities = (ahead - now) / (MOMENT * self.clock)
        return np.concatenate([now, velocities, states[..., SPIN] @ self._labels], axis=-1)
