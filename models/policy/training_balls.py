"""Training balls, flown and forecast by the policy's own simulator."""

from dataclasses import dataclass

import numpy as np

from models.ball.simulator import Simulator
from models.policy.forecasts import exact
from models.policy.goals import Goals, draw_goals
from models.policy.incoming_balls import IncomingBalls, fly_incoming
from models.policy.launches import draw_launches
from models.policy.settings import GoalSettings, HorizonsMs


@dataclass(frozen=True)
class TrainingBalls:
    """A ``BallSource`` with exact forecasts.

    Efficient for many balls at once: 0.3 ms and 125 kB per ball.

    Attributes:
        simulator: flies the balls.
        goals: their distribution.
        horizons: of the forecasts, ms.
    """

    simulator: Simulator
    goals: GoalSettings
    horizons: HorizonsMs

    def __call__(self, count: int, random: np.random.Generator) -> tuple[IncomingBalls, Goals]:
        """Return ``count`` balls, which depend on ``random`` alone."""
        path, playable = fly_incoming(self.simulator, draw_launches(self.simulator, count, random))
        incoming = IncomingBalls(path, playable, 0.0, exact(path, self.horizons))
        return incoming, draw_goals(self.goals, count, random)
