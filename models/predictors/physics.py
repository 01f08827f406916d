"""The physics predictor: a filter over the history, then a simulator; the paper's baseline."""

from models.ball.simulator import Simulator
from models.ball.state import POSITION
from models.predictors.ball_filter import filtered
from models.predictors.propagation import propagated
from models.predictors.protocol import FUTURE_TIMES, Floats, Forecast, History


class PhysicsPredictor:
    """Filters the history and simulates the flight from the filtered state."""

    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator

    def predict(self, history: History) -> Forecast:
        """Forecast each ball; one without any measurement is forecast at the table's centre."""
        now = filtered(history, self.simulator).states
        return Forecast(self.simulator.fly(now, FUTURE_TIMES).states, history.spin_measured)

    def predict_with_covariances(self, history: History) -> tuple[Forecast, Floats]:
        """Forecast each ball; the (B, 60, 3, 3) covariances of positions, m^2, are the filter's."""
        now = filtered(history, self.simulator)
        states, found = propagated(self.simulator, now.states, now.covariances, FUTURE_TIMES)
        return Forecast(states, history.spin_measured), found[..., POSITION, POSITION]
