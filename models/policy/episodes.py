"""Episodes: how they ended, and what that was worth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.policy.goals import Goals
from models.policy.outcome import judge
from models.policy.racket_contact import Encounters
from models.policy.reward import FAULT, contact_reward, goal_reward, miss_reward

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]
Strings = NDArray[np.str_]

# How episodes end: the racket meets the ball, or by one of these faults.
MET, MISSED, BEFORE_BOUNCE, ARM_ON_TABLE = "met", "missed", "before_bounce", "arm_on_table"


@dataclass(frozen=True)
class Episodes:
    """E episodes that ended.

    Attributes:
        arms: (E,) whose they were, growing.
        goals: (E,) that were asked for.
        hit: (E,) whether the racket met the ball, after its bounce.
        returned: (E,) whether the ball then landed as it must.
        fault: (E,) why it was not returned: ``missed``, ``before_bounce`` (the racket met it too
            early), ``arm_on_table``, ``net`` or ``out``; empty for a return.
        reward: (E,) that the end brought.
        goal_reward: (E,) the part of it that depends on the goal.
        nearest: (E,) m between the centres of ball and racket at their nearest, while the ball
            could be played; infinite if it never could.
        time: (E,) s from the launch to the hit; from here on NaN without a hit.
        after: (E, 9) the ball just after the hit.
        backhand: (E,) 1 if the racket's back hit the ball, else 0.
        landing: (E, 2) m, and so on, as in ``Outcome``.
        distance: (E,) m.
        net_height: (E,) m.
        speed: (E,) m/s.
        topspin: (E,) rad/s.
    """

    arms: Integers
    goals: Goals
    hit: Booleans
    returned: Booleans
    fault: Strings
    reward: Floats
    goal_reward: Floats
    nearest: Floats
    time: Floats
    after: Floats
    backhand: Floats
    landing: Floats
    distance: Floats
    net_height: Floats
    speed: Floats
    topspin: Floats


def concluded(
    simulator: Simulator,
    arms: Integers,
    endings: Strings,
    nearest: Floats,
    goals: Goals,
    hits: Encounters,
    times: Floats,
) -> Episodes:
    """Play the balls that were hit to their end, and sum up.

    Args:
        simulator: flies the balls on.
        arms: (E,) whose episodes ended.
        endings: (E,) ``MET`` or one of the faults.
        nearest: (E,) as in ``Episodes``.
        goals: (E,) of the episodes.
        hits: the H balls of the episodes that ended with ``MET``.
        times: (H,) s from the launch.
    """
    hit = endings == MET
    after = simulator.strike(hits.states, hits.normals, hits.velocities)
    outcome = judge(simulator, after, goals[hit])
    returned, fault = hit.copy(), endings.copy()
    returned[hit], fault[hit] = outcome.returned, outcome.fault
    reward = np.where(endings == MISSED, miss_reward(nearest), -FAULT)
    of_goals = np.zeros(len(endings))
    of_goals[hit] = goal_reward(
        outcome.landing, outcome.speed, outcome.topspin, outcome.returned, goals[hit]
    )
    reward[hit] = contact_reward(outcome, hits.backhand) + of_goals[hit]
    return Episodes(
        arms,
        goals,
        hit,
        returned,
        fault,
        reward,
        of_goals,
        nearest,
        time=_spread(hit, times),
        after=_spread(hit, after),
        backhand=_spread(hit, hits.backhand.astype(np.float64)),
        landing=_spread(hit, outcome.landing),
        distance=_spread(hit, outcome.distance),
        net_height=_spread(hit, outcome.net_height),
        speed=_spread(hit, outcome.speed),
        topspin=_spread(hit, outcome.topspin),
    )


def _spread(hit: Booleans, values: Floats) -> Floats:
    """Return (E, ...) values: those of the hits in their rows, NaN elsewhere."""
    spread = np.full((len(hit), *values.shape[1:]), np.nan)
    spread[hit] = values
    return spread
