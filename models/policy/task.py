"""Task: what a policy is trained for."""

from dataclasses import dataclass

from models.ball.simulator import Simulator
from models.policy.settings import GoalSettings, HorizonsMs, ObservationKind
from models.policy.training_balls import Practice


@dataclass(frozen=True)
class Task:
    """Balls of a simulator, what the policy is told of them, and what it is asked to do.

    Attributes:
        simulator: flies the balls, to the robot and back, and forecasts them.
        horizons: of the forecasts, ms.
        goals: what returns are asked to do.
        observation: what the policy sees.
    """

    simulator: Simulator
    horizons: HorizonsMs
    goals: GoalSettings
    observation: ObservationKind

    @property
    def practice(self) -> Practice:
        """The balls to train and to test on."""
        return Practice(self.simulator, self.goals, self.horizons)
