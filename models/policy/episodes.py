"""Ended episodes: how they ended, and their rewards."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.outcome import judge
from rallygap.models.policy.racket_contact import RacketContacts
from rallygap.models.policy.reward import FAULT, contact_reward, goal_reward, miss_reward

Strings = NDArray[np.str_]

# How episodes end: with a hit, or by one of these faults.
HIT, MISSED, BEFORE_BOUNCE, ARM_ON_TABLE = "hit", "missed", "before_bounce", "arm_on_table"
JUDGED = ("before_landing", "landing", "distance", "net_height", "speed", "topspin")  # of hits


@dataclass(frozen=True)
class Episodes:
    """E episodes that ended.

    Attributes:
        envs: (E,) indices of their environments, ascending.
        goals: (E,) goals.
        hit: (E,) whether the racket met the ball after its bounce.
        returned: (E,) whether the ball then landed on the far half.
        fault: (E,) why it was not returned: ``missed``, ``before_bounce`` (the racket met it too
            early), ``arm_on_table``, ``net`` or ``out``; empty for a return.
        reward: (E,) of the last step, without the effort.
        goal_reward: (E,) the part of it that depends on the goal.
        nearest: (E,) m, smallest distance between the centres of ball and racket while the ball
            could be played; infinite if it never could.
        time: (E,) s from the launch to the hit; NaN without a hit, like all that follows.
        after_racket: (E, 9) state just after the racket.
        before_landing: (E, 9) state just before the landing; NaN without a return.
        backhand: (E,) 1 if the racket's back hit the ball, else 0.
        landing: (E, 2) m; this and the rest as in ``Outcome``.
        distance: (E,) m.
        net_height: (E,) m.
        speed: (E,) m/s.
        topspin: (E,) rad/s.
    """

    envs: Integers
    goals: Goals
    hit: Bools
    returned: Bools
    fault: Strings
    reward: Floats
    goal_reward: Floats
    nearest: Floats
    time: Floats
    after_racket: Floats
    before_landing: Floats
    backhand: Floats
    landing: Floats
    distance: Floats
    net_height: Floats
    speed: Floats
    topspin: Floats


def conclude(
    simulator: Simulator,
    envs: Integers,
    endings: Strings,
    nearest: Floats,
    goals: Goals,
    hits: RacketContacts,
    times: Floats,
) -> Episodes:
    """Fly the balls that were hit to their end, and reward the episodes.

    Args:
        simulator: flies the balls on.
        envs: (E,) whose episodes ended.
        endings: (E,) ``HIT`` or one of the faults.
        nearest: (E,) as in ``Episodes``.
        goals: (E,) of the episodes.
        hits: the racket contacts of the H episodes that ended with ``HIT``.
        times: (H,) s from the launch.
    """
    hit = endings == HIT
    after = simulator.strike(hits.states, hits.normals, hits.velocities)
    outcome = judge(simulator, after, goals[hit])
    returned, fault = hit.copy(), endings.copy()
    returned[hit], fault[hit] = outcome.returned, outcome.fault
    reward = np.where(endings == MISSED, miss_reward(nearest), -FAULT)
    goal_rewards = np.zeros(len(endings))
    goal_rewards[hit] = goal_reward(
        outcome.landing, outcome.speed, outcome.topspin, outcome.returned, goals[hit]
    )
    reward[hit] = contact_reward(outcome, hits.backhand) + goal_rewards[hit]
    known = {"time": times, "after_racket": after, "backhand": hits.backhand}
    known |= {name: getattr(outcome, name) for name in JUDGED}
    of_hits = {}
    for name, values in known.items():
        of_hits[name] = np.full((len(hit), *values.shape[1:]), np.nan)
        of_hits[name][hit] = values
    return Episodes(envs, goals, hit, returned, fault, reward, goal_rewards, nearest, **of_hits)
