"""Trial: a policy plays balls, each once."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.policy.batch_simulation import Court
from models.policy.episodes import Episodes
from models.policy.goals import Goals
from models.policy.incoming_balls import Incoming
from models.policy.policy import Policy
from models.policy.settings import ObservationKind

ARMS = 32  # in one world; more of them move no faster, and all wait for the last ball
PLAIN = ("hit", "returned", "fault", "nearest", "time", "backhand", "distance", "net_height")
STYLE = ("speed", "topspin")


def play(
    policy: Policy, simulator: Simulator, incoming: Incoming, goals: Goals, kind: ObservationKind
) -> pd.DataFrame:
    """Return how B balls ended, a row each in their order.

    Columns are those of ``Episodes``: ``hit``, ``returned``, ``fault``, ``nearest``, ``time``,
    ``backhand``, ``distance``, ``net_height``, ``speed``, ``topspin``, ``landing_across`` and
    ``landing_along``; and what was asked for, ``goal_landing_across``, ``goal_landing_along`` and,
    where they were, ``goal_speed`` and ``goal_topspin``.

    Args:
        policy: decides.
        simulator: flies the balls on from the racket.
        incoming: (B,) balls, with what the policy's predictor says of them.
        goals: (B,) of their returns.
        kind: what the policy sees.
    """
    court = Court(simulator, min(ARMS, len(incoming)), kind)
    try:
        return pd.concat(_played(policy, court, incoming, goals)).sort_index()
    finally:
        court.close()


def _played(
    policy: Policy, court: Court, incoming: Incoming, goals: Goals
) -> Iterator[pd.DataFrame]:
    """Yield the balls that ended in each tick; an arm that is free gets the next ball."""
    balls = np.arange(len(court.over))  # that the arms have
    served, free = 0, balls
    while served < len(incoming) or not court.over.all():
        free = free[: len(incoming) - served]
        balls[free] = served + np.arange(len(free))
        served += len(free)
        _serve(court, free, incoming[balls[free]], goals[balls[free]])
        step = court.step(policy.act(court.observe()))
        free = step.ended.arms
        yield _table(step.ended, balls[free])


def _serve(court: Court, arms: NDArray[np.int64], incoming: Incoming, goals: Goals) -> None:
    if len(arms):
        which = np.zeros(len(court.over), dtype=np.bool_)
        which[arms] = True
        court.reset(which, incoming, goals)


def _table(ended: Episodes, balls: NDArray[np.int64]) -> pd.DataFrame:
    columns = {name: getattr(ended, name) for name in (*PLAIN, *STYLE)}
    columns["landing_across"], columns["landing_along"] = ended.landing.T
    columns["goal_landing_across"], columns["goal_landing_along"] = ended.goals.landing.T
    for name in STYLE:
        asked = getattr(ended.goals, name)
        if asked is not None:
            columns[f"goal_{name}"] = asked
    return pd.DataFrame(columns, index=balls)
