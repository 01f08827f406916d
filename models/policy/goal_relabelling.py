"""Goal relabelling: a replay buffer that hands out each transition with a newly drawn goal.

The reward of a stroke under any goal follows from where the ball landed, its speed and its topspin;
nothing else depends on the goal. So one stroke teaches all shots (universal value functions, Schaul
2015). Hindsight experience replay (Andrychowicz 2017) relabels with achieved goals instead.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.type_aliases import ReplayBufferSamples
from stable_baselines3.common.vec_env import VecNormalize

from rallygap.models.ball.types import Integers
from rallygap.models.policy.goals import draw_goals
from rallygap.models.policy.reward import goal_reward
from rallygap.models.policy.settings import GoalSettings, RewardSettings

Floating = NDArray[np.floating]

STROKE_SIZE = 5  # landing x and y, speed, topspin, whether returned


class RelabellingReplayBuffer(ReplayBuffer):
    """Stable-Baselines3's replay buffer with goals drawn for every sample.

    Attributes:
        strokes: (N, B, 5) of transitions that ended with a hit, NaN elsewhere.
    """

    def __init__(
        self,
        *args: Any,
        goals: GoalSettings,
        columns: slice,
        weights: RewardSettings,
        **others: Any,
    ) -> None:
        """Make an empty buffer; ``columns`` of an observation hold the goal."""
        super().__init__(*args, **others)
        self.strokes = np.full((self.buffer_size, self.n_envs, STROKE_SIZE), np.nan, np.float32)
        self._goals, self._columns, self._weights = goals, columns, weights

    def add(
        self,
        obs: Floating,
        next_obs: Floating,
        action: Floating,
        reward: Floating,
        done: Floating,
        infos: list[dict[str, Any]],
    ) -> None:
        """Store a transition of each environment, its reward without the goal's part."""
        for env, info in enumerate(infos):
            stroke = [np.nan] * STROKE_SIZE
            if info.get("hit"):
                stroke = [*info["landing"], info["speed"], info["topspin"], info["returned"]]
            self.strokes[self.pos, env] = stroke
        goal_rewards = np.array([info.get("goal_reward", 0.0) for info in infos])
        super().add(obs, next_obs, action, reward - goal_rewards, done, infos)

    def _get_samples(
        self, batch_inds: Integers, env: VecNormalize | None = None
    ) -> ReplayBufferSamples:
        indices = batch_inds, np.random.randint(self.n_envs, size=len(batch_inds))
        random = np.random.default_rng(np.random.randint(2**31, size=4))
        goals = draw_goals(self._goals, len(batch_inds), random)
        now, after = self.observations[indices], self.next_observations[indices]
        now[:, self._columns] = after[:, self._columns] = goals.scaled()
        strokes = self.strokes[indices].astype(np.float64)
        landing, (speed, topspin, returned) = strokes[:, :2], strokes[:, 2:].T
        goal_rewards = goal_reward(landing, speed, topspin, returned == 1, goals, self._weights)
        rewards = self.rewards[indices] + np.nan_to_num(goal_rewards)
        parts = (now, self.actions[indices], after, _column(self.dones[indices]), _column(rewards))
        return ReplayBufferSamples(*(self.to_torch(part) for part in parts))


def _column(values: Floating) -> NDArray[np.float32]:
    return values.astype(np.float32)[:, None]
