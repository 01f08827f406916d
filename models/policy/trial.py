"""Trials: a policy plays balls, each once, in parallel environments.

One run of Bullet yields everything that is asked for: how each ball ended, its states after the
racket and before the landing, and recorded motions.
"""

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass

import numpy as np
import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats, Integers
from rallygap.models.policy.batch_simulation import BatchSimulation
from rallygap.models.policy.episodes import OUTCOMES, STYLE, Episodes
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.incoming_balls import IncomingBalls
from rallygap.models.policy.motion_recording import Motion, MotionRecorder
from rallygap.models.policy.policy import Policy
from rallygap.models.policy.settings import ObservationKind

ENVIRONMENTS = 32  # in one world; more are no faster, and all wait for the last ball


@dataclass(frozen=True)
class TrialResult:
    """How B balls ended, in their order.

    Attributes:
        table: one row per ball: the columns of ``Episodes`` (``OUTCOMES``, ``STYLE``,
            ``landing_across``, ``landing_along``) and the goals (``goal_landing_across``,
            ``goal_landing_along``, and ``goal_speed`` and ``goal_topspin`` where they are set).
        after_racket: (B, 9) states just after the racket; NaN without a hit.
        before_landing: (B, 9) states just before the landing; NaN without a return.
        motions: of the first balls, as many as were to be recorded.
    """

    table: pd.DataFrame
    after_racket: Floats
    before_landing: Floats
    motions: Sequence[Motion] = ()


def play(
    policy: Policy,
    simulator: Simulator,
    incoming: IncomingBalls,
    goals: Goals,
    kind: ObservationKind,
    record: int = 0,
    latency: float = 0.0,
) -> TrialResult:
    """Let a policy play B balls.

    Args:
        policy: decides.
        simulator: flies the balls on from the racket.
        incoming: (B,) balls with the forecasts of the policy's predictor.
        goals: (B,) of their returns.
        kind: what the policy observes.
        record: how many of the first balls to record. An environment records until the ball is
            down, so a recorded ball takes about twice as long.
        latency: s from an action to the arm.
    """
    recorder = MotionRecorder(simulator, incoming, record)
    count = min(ENVIRONMENTS, len(incoming))
    with closing(BatchSimulation(simulator, count, kind, latency)) as simulation:
        ended = list(_played(policy, simulation, incoming, goals, recorder))
    order = np.argsort(np.concatenate([balls for balls, _ in ended]))
    table = pd.concat([_table(episodes, balls) for balls, episodes in ended])
    after = np.concatenate([episodes.after_racket for _, episodes in ended])
    before = np.concatenate([episodes.before_landing for _, episodes in ended])
    return TrialResult(table.sort_index(), after[order], before[order], recorder.motions())


def _played(
    policy: Policy,
    simulation: BatchSimulation,
    incoming: IncomingBalls,
    goals: Goals,
    recorder: MotionRecorder,
) -> Iterator[tuple[Integers, Episodes]]:
    """Yield the balls that ended in each control step; a free environment gets the next ball."""
    balls = np.full(len(simulation.finished), -1)  # of each environment
    started = 0
    while started < len(incoming) or not simulation.finished.all() or recorder.active(balls).any():
        free = simulation.finished & ~recorder.active(balls)
        free &= np.cumsum(free) <= len(incoming) - started
        if free.any():
            balls[free] = started + np.arange(free.sum())
            started += int(free.sum())
            simulation.reset(free, incoming[balls[free]], goals[balls[free]])
            recorder.start(simulation, balls, free)
        ended = simulation.step(policy.act(simulation.observe())).ended
        recorder.add(simulation, balls, ended)
        yield balls[ended.envs], ended


def _table(ended: Episodes, balls: Integers) -> pd.DataFrame:
    columns = {name: getattr(ended, name) for name in (*OUTCOMES, *STYLE)}
    columns["landing_across"], columns["landing_along"] = ended.landing.T
    columns["goal_landing_across"], columns["goal_landing_along"] = ended.goals.landing.T
    for name in STYLE:
        goal = getattr(ended.goals, name)
        if goal is not None:
            columns[f"goal_{name}"] = goal
    return pd.DataFrame(columns, index=balls)
