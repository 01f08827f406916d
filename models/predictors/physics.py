"""The physics predictor: a filter over the history, then a simulator; the paper's baseline."""

from models.ball.simulator import Simulator
from models.ball.state import POSITION
from models.predictors.ball_filter import ANY_BALL, Expected, Filtered, filtered
from models.predictors.propagation import propagated
from models.predictors.protocol import FUTURE_TIMES, TICK, Floats, Forecast, History
from models.predictors.sensor import Sensor


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
        flown = self.simulator.fly(self._now(history).states, self._ahead).states
        return Forecast(self._sensor.measured_states(flown), history.spin_measured)

    def predict_with_covariances(self, history: History) -> tuple[Forecast, Floats]:
        """Forecast each ball; the (B, 60, 3, 3) covariances of positions, m^2, are the filter's."""
        now = self._now(history)
        flown, found = propagated(self.simulator, now.states, now.covariances, self._ahead)
        forecast = Forecast(self._sensor.measured_states(flown), history.spin_measured)
        return forecast, found[..., POSITION, POSITION]

    def _now(self, history: History) -> Filtered:
        true, tick = self._sensor.true_history(history), TICK / self._sensor.clock
        return filtered(true, self.simulator, self.expected, tick)

    @property
    def _ahead(self) -> Floats:
        """(60,) true s from now to the future states."""
        ahead: Floats = FUTURE_TIMES / self._sensor.clock
        return ahead
