"""Ended episodes: how they ended, and their rewards."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.outcome import Outcome, judge
from rallygap.models.policy.racket_contact import RacketContacts
from rallygap.models.policy.reward import contact_reward, goal_reward, miss_reward
from rallygap.models.policy.settings import RewardSettings

Strings = NDArray[np.str_]

# How episodes end: with a hit, or by one of these faults.
HIT, MISSED, BEFORE_BOUNCE, ARM_ON_TABLE = "hit", "missed", "before_bounce", "arm_on_table"
# Columns that tables and infos report.
OUTCOMES = ("hit", "returned", "fault", "nearest", "time", "backhand", "distance", "net_height")
STYLE = ("speed", "topspin")  # goals that not every policy has


@dataclass(frozen=True)
class Episodes(Outcome):
    """E episodes that ended, with the outcomes of their strokes, NaN without a hit.

    ``returned`` and ``fault`` are those of all episodes: further faults are ``missed``,
    ``before_bounce`` (the racket met the ball too early) and ``arm_on_table``.

    Attributes:
        envs: (E,) indices of their environments, ascending.
        goals: (E,) goals.
        hit: (E,) whether the racket met the ball after its bounce.
        reward: (E,) of the last step, without the effort.
        goal_reward: (E,) the part of it that depends on the goal.
        nearest: (E,) m, smallest distance between the centres of ball and racket while the ball
            could be played; infinite if it never could.
        time: (E,) s from the launch to the hit; NaN without a hit, like all that follows.
        after_racket: (E, 9) state just after the racket.
        backhand: (E,) 1 if the racket's back hit the ball, else 0.
    """

    envs: Integers
    goals: Goals
    hit: Bools
    reward: Floats
    goal_reward: Floats
    nearest: Floats
    time: Floats
    after_racket: Floats
    backhand: Floats


def conclude(
    simulator: Simulator,
    envs: Integers,
    endings: Strings,
    nearest: Floats,
    goals: Goals,
    hits: RacketContacts,
    times: Floats,
    weights: RewardSettings,
) -> Episodes:
    """Fly the balls that were hit to their end, and reward the episodes of (E,) ``envs``.

    ``endings`` (E,) are ``HIT`` or a fault; ``hits`` and ``times``, (H,) s from the launch, are
    those of the episodes that ended with ``HIT``.
    """
    hit = endings == HIT
    after = simulator.strike(hits.states, hits.normals, hits.velocities)
    outcome = judge(simulator, after, goals[hit])
    reward = np.where(endings == MISSED, miss_reward(nearest, weights), -weights.fault)
    goal_rewards = np.zeros(len(endings))
    goal_rewards[hit] = goal_reward(
        outcome.landing, outcome.speed, outcome.topspin, outcome.returned, goals[hit], weights
    )
    reward[hit] = contact_reward(outcome, hits.backhand, weights) + goal_rewards[hit]
    of_hits = vars(outcome) | {"time": times, "after_racket": after, "backhand": hits.backhand}
    columns: dict[str, Any] = {"returned": hit.copy(), "fault": endings.copy()}
    for name, values in of_hits.items():
        columns.setdefault(name, np.full((len(hit), *values.shape[1:]), np.nan))[hit] = values
    return Episodes(
        envs=envs,
        goals=goals,
        hit=hit,
        reward=reward,
        goal_reward=goal_rewards,
        nearest=nearest,
        **columns,
    )
