"""Struck: the ball just after the racket, of balls that a policy plays once more."""

from contextlib import closing

import numpy as np
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.ball.state import STATE_SIZE
from models.policy.batch_simulation import Court
from models.policy.goals import Goals
from models.policy.incoming_balls import Incoming
from models.policy.policy import Policy
from models.policy.settings import ObservationKind
from models.policy.trial import ARMS

Floats = NDArray[np.float64]


def struck(
    policy: Policy, simulator: Simulator, incoming: Incoming, goals: Goals, kind: ObservationKind
) -> Floats:
    """Return (B, 9) states just after the racket; NaN where it did not meet the ball.

    An arm moves alike whoever plays beside it, so these are the strokes of ``play``.

    Args:
        policy: decides.
        simulator: makes of the contact what it says of the racket.
        incoming: (B,) balls, with what the policy's predictor says of them.
        goals: (B,) of their returns.
        kind: what the policy sees.
    """
    after = np.full((len(incoming), STATE_SIZE), np.nan)
    for first in range(0, len(incoming), ARMS):
        rows = np.arange(first, min(first + ARMS, len(incoming)))
        with closing(Court(simulator, len(rows), kind)) as court:
            court.reset(np.ones(len(rows), dtype=np.bool_), incoming[rows], goals[rows])
            while not court.over.all():
                ended = court.step(policy.act(court.observe())).ended
                after[rows[ended.arms]] = ended.after
    return after
