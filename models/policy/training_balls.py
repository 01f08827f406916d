"""Practice: the balls a policy trains on, flown and forecast by its own simulator."""

from dataclasses import dataclass

import numpy as np

from models.ball.simulator import Simulator
from models.policy.forecasts import exact
from models.policy.goals import Goals, draw_goals
from models.policy.incoming_balls import Incoming, fly_in
from models.policy.launches import draw_launches
from models.policy.settings import GoalSettings, HorizonsMs


@dataclass(frozen=True)
class Practice:
    """A source of balls, ``Balls``, with exact forecasts and goals.

    Ask for many at once: a ball then takes a third of a millisecond, and 125 kB.

    Attributes:
        simulator: that flies the balls.
        goals: what returns are asked to do.
        horizons: of the forecasts, ms.
    """

    simulator: Simulator
    goals: GoalSettings
    horizons: HorizonsMs

    def __call__(self, count: int, random: np.random.Generator) -> tuple[Incoming, Goals]:
        """Return ``count`` balls, which depend on ``random`` alone."""
        path, playable = fly_in(self.simulator, draw_launches(self.simulator, count, random))
        incoming = Incoming(path, playable, 0.0, exact(path, self.horizons))
        return incoming, draw_goals(self.goals, count, random)
