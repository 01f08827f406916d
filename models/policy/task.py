"""The task that a policy is trained for."""

from dataclasses import dataclass

from models.ball.simulator import Simulator
from models.policy.settings import GoalSettings, HorizonsMs, ObservationKind
from models.policy.training_balls import TrainingBalls


@dataclass(frozen=True)
class Task:
    """Simulator, forecast horizons, goals and observation of a policy.

    Attributes:
        simulator: flies the balls to the robot and back, and forecasts them.
        horizons: of the forecasts, ms.
        goals: their distribution.
        observation: what the policy observes.
    """

    simulator: Simulator
    horizons: HorizonsMs
    goals: GoalSettings
    observation: ObservationKind

    @property
    def training_balls(self) -> TrainingBalls:
        """Source of balls for training and testing."""
        return TrainingBalls(self.simulator, self.goals, self.horizons)
