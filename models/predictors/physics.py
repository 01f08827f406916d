"""The physics predictor: a filter over the history, then a simulator; the paper's baseline."""

from rallygap.models.ball.simulator import Simulator
from rallygap.models.predictors.ball_filter import ANY_BALL, Expected, Filtered, filtered
from rallygap.models.predictors.propagation import propagated
from rallygap.models.predictors.protocol import FUTURE_TIMES, TICK, Floats, Forecast, History
from rallygap.models.predictors.sensor import Sensor


class PhysicsPredictor:
    """Filters the history and simulates the flight from the filtered state.

    Measurements and forecasts are those of the simulator's sensor.

    Args:
        simulator: of the ball and of the sensor.
        expected: of the balls.
    """

    def __init__(self, simulator: Simulator, expected: Expected = ANY_BALL) -> None:
        self.simulator, self.expected = simulator, expected
        self._sensor = Sensor(simulator)

    def predict(self, history: History) -> Forecast:
        """Forecast each ball; one without any measurement is forecast at the table's centre."""
        return Forecast(self.states_at(history, FUTURE_TIMES), history.spin_measured)

    def states_at(self, history: History, ahead: Floats) -> Floats:
        """Return the (B, T, 9) states at (T,) or (B, T) s after the history, not falling."""
        true = ahead / self._sensor.clock
        flown = self.simulator.fly(self._now(history).states, true).states
        return self._sensor.measured_states(flown)

    def predict_with_covariances(self, history: History) -> tuple[Forecast, Floats]:
        """Forecast each ball; the (B, 60, 3, 3) covariances of positions, m^2, are the filter's."""
        now = self._now(history)
        ahead = FUTURE_TIMES / self._sensor.clock
        flown, covariances = propagated(
            self.simulator, now.states, now.covariances, ahead, components=3
        )
        forecast = Forecast(self._sensor.measured_states(flown), history.spin_measured)
        return forecast, covariances

    def _now(self, history: History) -> Filtered:
        true, tick = self._sensor.true_history(history), TICK / self._sensor.clock
        return filtered(true, self.simulator, self.expected, tick)
