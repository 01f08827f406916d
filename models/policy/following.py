"""Following balls: a scripted motion for the warm-up of a training, before its first gradient step.

So the replay buffer begins with strokes: this motion hits two balls in three and returns one in
six, uniformly drawn actions hit one in fifty.
"""

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.policy.observation import plane_crossing
from rallygap.models.robot.kinematics import Racket

GAIN = 8.0  # of the racket's velocity across and up, 1/m: full speed at an eighth of a metre
NEAR = 0.075  # s from the nearest forecast to the crossing, from when rackets move ahead
NOISE = np.array([0.1, 0.3, 0.1, 0.2, 0.2])  # standard deviations of actions


def following_actions(rackets: Racket, forecasts: Floats, random: np.random.Generator) -> Floats:
    """Return (B, 5) actions that bring rackets to where balls cross their planes.

    Args:
        rackets: B of them.
        forecasts: (B, 9), of the nearest horizon.
        random: for the noise, and for how fast a racket moves ahead once its ball is near.
    """
    crossing = plane_crossing(rackets, forecasts)
    time, away = crossing[:, 0], crossing[:, 1:3]
    actions = NOISE * random.standard_normal((len(time), len(NOISE)))
    actions[:, [0, 2]] += GAIN * away
    actions[:, 1] = np.where(time < NEAR, random.uniform(size=len(time)), actions[:, 1])
    return np.clip(actions, -1.0, 1.0)
