"""Court: arms, each with its ball, from decision to decision."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.policy.balls_in_flight import TICK_STEPS, Deliveries
from models.policy.episodes import (
    ARM_ON_TABLE,
    BEFORE_BOUNCE,
    MET,
    MISSED,
    Episodes,
    concluded,
)
from models.policy.goals import Goals
from models.policy.incoming_balls import PATH_STEP, TICK, Incoming
from models.policy.observation import Observations, observe
from models.policy.outcome import with_net
from models.policy.racket_contact import Encounters, distances, encounters, swing
from models.policy.reward import effort_reward
from models.policy.settings import ObservationKind
from models.robot.arms import Arms
from models.robot.constants import BULLET_STEP, COMMAND_STEP
from models.robot.control import joint_speeds

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]

# What an action of one asks of the racket: m/s across, along and up; rad/s of its two turns.
VELOCITY = np.array([2.5, 1.5, 2.0])
TURNING = 6.0
ACTIONS = 5

COMMANDS = round(TICK / COMMAND_STEP)  # a tick; the joints' speeds are worked out for each
STEPS = round(COMMAND_STEP / BULLET_STEP)  # of Bullet, a command
PIECES = round(BULLET_STEP / PATH_STEP)  # path steps in a step of Bullet


@dataclass(frozen=True)
class Step:
    """What a tick brought to B arms.

    Attributes:
        observation: (B, O) at its end.
        reward: (B,); zero where the episode was over before.
        done: (B,) whether the episode ended in this tick.
        ended: the episodes that did.
    """

    observation: Observations
    reward: Floats
    done: Booleans
    ended: Episodes


class Court:
    """B arms, each with a ball of its own.

    Attributes:
        arms: the robots.
        over: (B,) whether the arm's episode has ended; it holds still until it gets another ball.
    """

    def __init__(self, simulator: Simulator, count: int, kind: ObservationKind) -> None:
        """Set up a court on which balls fly on from the rackets as ``simulator`` says."""
        self.arms = Arms(count)
        self.over = np.ones(count, dtype=np.bool_)
        self._simulator, self._kind = with_net(simulator), kind
        self._nearest = np.full(count, np.inf)
        self._balls: Deliveries
        self._goals: Goals

    def reset(self, which: Booleans, incoming: Incoming, goals: Goals) -> None:
        """Begin new episodes.

        Args:
            which: (B,) the arms; all of them the first time.
            incoming: a ball for each of these, with paths and forecasts as long as before.
            goals: of these balls, of the same kinds as before.
        """
        if which.all():
            self._balls, self._goals = Deliveries(incoming), goals[np.arange(len(goals))]
        else:
            self._balls.replace(which, incoming)
            _replace(self._goals, which, goals)
        self.arms.reset(which)
        self.over[which], self._nearest[which] = False, np.inf

    def observe(self) -> Observations:
        """Return the (B, O) observations of all arms."""
        arms, forecasts = self.arms, self._balls.forecasts
        return observe(arms.joints, arms.joint_speeds, forecasts, self._goals, self._kind)

    def step(self, actions: NDArray[np.floating]) -> Step:
        """Let one tick pass.

        Args:
            actions: (B, 5) in [-1, 1]: velocity of the racket across, along and up, and its two
                turning rates, as ``models.robot.control`` defines them.
        """
        wanted = np.where(self.over[:, None], 0.0, np.clip(actions, -1.0, 1.0))
        rackets, touched = self._move(wanted)
        moments, balls = self._balls.ahead()
        apart = distances(balls, rackets)
        self._note_nearest(moments, apart)
        live = (moments[1:] <= self._balls.gone) & ~self.over & ~touched[:-1]
        ended = self._ended(encounters(balls, rackets, apart, live), touched[-1])
        self._balls.advance()
        reward, done = effort_reward(wanted), np.zeros(len(wanted), dtype=np.bool_)
        reward[ended.arms] += ended.reward
        done[ended.arms] = True
        self.over |= done
        return Step(self.observe(), reward, done, ended)

    def close(self) -> None:
        """Give the arms' world back."""
        self.arms.close()

    def _move(self, wanted: Floats) -> tuple[Floats, Booleans]:
        """Move the arms for a tick.

        Returns:
            Rackets (S + 1, B, 12) as ``swing`` has them, and whether the arms have touched the
            table by then, (S + 1, B).
        """
        arms = self.arms
        joints, speeds = [arms.joints.copy()], [arms.joint_speeds.copy()]
        touched = [np.zeros(len(wanted), dtype=np.bool_)]
        velocity, turning = VELOCITY * wanted[:, :3], TURNING * wanted[:, 3:]
        for _ in range(COMMANDS):
            arms.command(joint_speeds(arms.joints, velocity, turning))
            for _ in range(STEPS):
                arms.step()
                joints.append(arms.joints.copy())
                speeds.append(arms.joint_speeds.copy())
                touched.append(touched[-1] | arms.touching_table())
        rackets = swing(np.array(joints), np.array(speeds), PIECES)
        return rackets, np.repeat(touched, PIECES, axis=0)[: len(rackets)]

    def _note_nearest(self, moments: Integers, apart: Floats) -> None:
        playable = (moments >= self._balls.bounce) & (moments <= self._balls.gone)
        nearest = np.where(playable, apart, np.inf).min(axis=0)
        self._nearest = np.minimum(self._nearest, nearest)

    def _ended(self, met: Encounters, touched: Booleans) -> Episodes:
        """Return the episodes that end in this tick, given who met the ball or the table."""
        first = self._balls.first
        moments = np.full(len(first), np.nan)
        moments[met.arms] = first[met.arms] + met.moments
        hit = moments >= self._balls.bounce
        gone = first + TICK_STEPS >= self._balls.gone
        endings = np.select(
            [hit, ~np.isnan(moments), touched, gone], [MET, BEFORE_BOUNCE, ARM_ON_TABLE, MISSED], ""
        )
        arms = np.flatnonzero((endings != "") & ~self.over)
        return concluded(
            self._simulator,
            arms,
            endings[arms],
            self._nearest[arms],
            self._goals[arms],
            met[hit[met.arms]],
            moments[hit] * PATH_STEP,
        )


def _replace(kept: Goals, which: Booleans, goals: Goals) -> None:
    for field in fields(Goals):
        column = getattr(kept, field.name)
        if column is not None:
            column[which] = getattr(goals, field.name)
