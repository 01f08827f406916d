"""Batch simulation: parallel environments in one Bullet world."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.policy.episodes import (
    ARM_ON_TABLE,
    BEFORE_BOUNCE,
    HIT,
    MISSED,
    Episodes,
    conclude,
)
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.incoming_balls import (
    CONTROL_STEP,
    PATH_STEP,
    PATH_STEPS_PER_CONTROL,
    BallsInFlight,
    IncomingBalls,
)
from rallygap.models.policy.observation import Observations, observe, plane_crossing
from rallygap.models.policy.outcome import with_net
from rallygap.models.policy.racket_contact import (
    RacketContacts,
    distances,
    find_contacts,
    racket_path,
)
from rallygap.models.policy.reward import effort_reward
from rallygap.models.policy.settings import DEFAULT_REWARD, ObservationKind, RewardSettings
from rallygap.models.robot.arms import Arms
from rallygap.models.robot.constants import BULLET_STEP, COMMAND_STEP
from rallygap.models.robot.control import joint_speeds
from rallygap.models.robot.kinematics import racket

# Racket motion for an action of one: m/s across, along and up; rad/s of its two turning rates.
VELOCITY = np.array([2.5, 1.5, 2.0])
TURNING = 6.0
ACTIONS = 5

COMMANDS = round(CONTROL_STEP / COMMAND_STEP)  # of joint speeds, per control step
BULLET_STEPS = round(COMMAND_STEP / BULLET_STEP)  # per command
PATH_STEPS = round(BULLET_STEP / PATH_STEP)  # per Bullet step

# Following balls.
GAIN = 8.0  # of the racket's velocity across and up, 1/m: full speed at an eighth of a metre
NEAR = 0.075  # s from the nearest forecast to the crossing, from when rackets move ahead
NOISE = np.array([0.1, 0.3, 0.1, 0.2, 0.2])  # standard deviations of actions


@dataclass(frozen=True)
class StepResult:
    """What one control step brought to B environments.

    Attributes:
        observation: (B, O) at its end.
        reward: (B,); zero where the episode had ended before.
        done: (B,) whether the episode ended in this step.
        ended: the episodes that did.
    """

    observation: Observations
    reward: Floats
    done: Bools
    ended: Episodes


class BatchSimulation:
    """B environments, each with an arm and a ball.

    Attributes:
        arms: the robots.
        finished: (B,) whether the episode has ended; the arm rests until the next reset.
    """

    def __init__(
        self,
        simulator: Simulator,
        count: int,
        kind: ObservationKind,
        latency: float = 0.0,
        weights: RewardSettings = DEFAULT_REWARD,
    ) -> None:
        """Set up environments.

        Args:
            simulator: flies balls on from the rackets.
            count: of environments.
            kind: what is observed.
            latency: s from an action to the first command to the arm that follows it.
            weights: of the reward.
        """
        self.arms = Arms(count)
        self._delay = round(latency / COMMAND_STEP)
        self._actions = np.zeros((1 - (-self._delay // COMMANDS), count, ACTIONS))  # newest last
        self.finished = np.ones(count, dtype=np.bool_)
        self._simulator, self._kind = with_net(simulator), kind
        self._weights = weights
        self._nearest = np.full(count, np.inf)
        self._balls: BallsInFlight
        self._goals: Goals

    def reset(self, which: Bools, incoming: IncomingBalls, goals: Goals) -> None:
        """Start new episodes.

        Args:
            which: (B,) the environments; all of them the first time.
            incoming: a ball for each of these, with paths and forecasts as long as before.
            goals: of these balls, of the same kinds as before.
        """
        if which.all():
            self._balls, self._goals = BallsInFlight(incoming), goals[np.arange(len(goals))]
        else:
            self._balls.replace(which, incoming)
            for kept, new in zip(vars(self._goals).values(), vars(goals).values(), strict=True):
                if kept is not None:
                    kept[which] = new
        self.arms.reset(which)
        self._actions[:, which] = 0.0
        self.finished[which], self._nearest[which] = False, np.inf

    def observe(self) -> Observations:
        """Return the (B, O) observations of all environments."""
        arms, balls = self.arms, self._balls
        return observe(
            arms.joints, arms.joint_speeds, balls.forecasts, balls.spreads, self._goals, self._kind
        )

    def following_actions(self, random: np.random.Generator) -> Floats:
        """Return (B, 5) actions that bring rackets to where balls cross their planes, with noise.

        The warm-up of a training uses them, so that its replay buffer begins with strokes: they
        hit two balls in three and return one in six, uniformly drawn actions hit one in fifty.
        How fast a racket moves ahead once its ball is near is random.
        """
        rackets = racket(self.arms.joints, self.arms.joint_speeds)
        crossing = plane_crossing(rackets, self._balls.forecasts[:, 0])
        time, away = crossing[:, 0], crossing[:, 1:3]
        actions = NOISE * random.standard_normal((len(time), len(NOISE)))
        actions[:, [0, 2]] += GAIN * away
        actions[:, 1] = np.where(time < NEAR, random.uniform(size=len(time)), actions[:, 1])
        return np.clip(actions, -1.0, 1.0)

    def step(self, actions: NDArray[np.floating]) -> StepResult:
        """Simulate one control step.

        Args:
            actions: (B, 5) in [-1, 1]: velocity of the racket across, along and up, and its two
                turning rates, as ``rallygap.models.robot.control`` defines them.
        """
        clipped = np.clip(actions, -1.0, 1.0)
        self._actions = np.concatenate([self._actions[1:], clipped[None]])
        self._actions[:, self.finished] = 0.0
        rackets, on_table = self._move()
        moments, balls = self._balls.ahead()
        distance = distances(balls, rackets)
        playable = (moments >= self._balls.bounce) & (moments <= self._balls.gone)
        nearest = np.where(playable, distance, np.inf).min(axis=0)
        self._nearest = np.minimum(self._nearest, nearest)
        live = (moments[1:] <= self._balls.gone) & ~self.finished & ~on_table[:-1]
        ended = self._ended(find_contacts(balls, rackets, distance, live), on_table[-1])
        self._balls.advance()
        reward = effort_reward(self._actions[-1], self._weights)
        done = np.zeros(len(clipped), dtype=np.bool_)
        reward[ended.envs] += ended.reward
        done[ended.envs] = True
        self.finished |= done
        return StepResult(self.observe(), reward, done, ended)

    def close(self) -> None:
        """Release the Bullet world."""
        self.arms.close()

    def _move(self) -> tuple[Floats, Bools]:
        """Move the arms for one control step.

        Returns:
            Rackets (S + 1, B, 12) as ``racket_path`` returns them, and whether the arms have
            touched the table by then, (S + 1, B).
        """
        arms = self.arms
        joints, speeds = [arms.joints.copy()], [arms.joint_speeds.copy()]
        touched = [np.zeros(len(self.finished), dtype=np.bool_)]
        for command in range(COMMANDS):
            steps_ago = max(-((command - self._delay) // COMMANDS), 0)
            actions = self._actions[-1 - steps_ago]
            velocity, turning = VELOCITY * actions[:, :3], TURNING * actions[:, 3:]
            arms.command(joint_speeds(arms.joints, velocity, turning))
            for _ in range(BULLET_STEPS):
                arms.step()
                joints.append(arms.joints.copy())
                speeds.append(arms.joint_speeds.copy())
                touched.append(touched[-1] | arms.touching_table())
        rackets = racket_path(np.array(joints), np.array(speeds), PATH_STEPS)
        return rackets, np.repeat(touched, PATH_STEPS, axis=0)[: len(rackets)]

    def _ended(self, contacts: RacketContacts, on_table: Bools) -> Episodes:
        """Return the episodes that end, given racket contacts and arms on the table."""
        first = self._balls.first
        moments = np.full(len(first), np.nan)
        moments[contacts.envs] = first[contacts.envs] + contacts.moments
        hit = moments >= self._balls.bounce
        gone = first + PATH_STEPS_PER_CONTROL >= self._balls.gone
        endings = np.select(
            [hit, ~np.isnan(moments), on_table, gone],
            [HIT, BEFORE_BOUNCE, ARM_ON_TABLE, MISSED],
            "",
        )
        envs = np.flatnonzero((endings != "") & ~self.finished)
        return conclude(
            self._simulator,
            envs,
            endings[envs],
            self._nearest[envs],
            self._goals[envs],
            contacts[hit[contacts.envs]],
            moments[hit] * PATH_STEP,
            self._weights,
        )
