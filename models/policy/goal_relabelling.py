"""Retelling: what befell an arm teaches for every goal, not only for the one that it had.

What a stroke is worth under any goal follows from where the ball landed, how fast and with what
spin, and nothing else that happens knows of the goal. So every transition that a learner draws is
told under a goal drawn anew, and one stroke teaches all shots (universal value functions, Schaul
2015; hindsight experience replay, Andrychowicz 2017, tells them under goals that were achieved).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.type_aliases import ReplayBufferSamples
from stable_baselines3.common.vec_env import VecNormalize

from models.policy.goals import draw_goals
from models.policy.reward import goal_reward
from models.policy.settings import GoalSettings

Floats = NDArray[np.floating]
Integers = NDArray[np.int64]

STROKE = 5  # numbers: where the ball landed (2), its speed and topspin, whether it was returned
_NO_STROKE = (np.nan,) * STROKE


class RetoldReplay(ReplayBuffer):
    """A replay buffer that tells its transitions under new goals.

    Attributes:
        strokes: (N, B, 5) of transitions that ended with a stroke, NaN elsewhere.
    """

    def __init__(self, *args: Any, goals: GoalSettings, columns: slice, **others: Any) -> None:
        """Make an empty one.

        Args:
            args: of Stable-Baselines3's own.
            goals: from what goals are drawn.
            columns: of an observation, in which the goal stands.
            others: of Stable-Baselines3's own.
        """
        super().__init__(*args, **others)
        self.strokes = np.full((self.buffer_size, self.n_envs, STROKE), np.nan, np.float32)
        self._goals, self._columns = goals, columns

    def add(
        self,
        obs: Floats,
        next_obs: Floats,
        action: Floats,
        reward: Floats,
        done: Floats,
        infos: list[dict[str, Any]],
    ) -> None:
        """Keep a transition of each arm, its reward without the part that the goal decides."""
        self.strokes[self.pos] = [_stroke(info) for info in infos]
        of_goals = np.array([info.get("goal_reward", 0.0) for info in infos])
        super().add(obs, next_obs, action, reward - of_goals, done, infos)

    def _get_samples(
        self, batch_inds: Integers, env: VecNormalize | None = None
    ) -> ReplayBufferSamples:
        places = batch_inds, np.random.randint(self.n_envs, size=len(batch_inds))
        random = np.random.default_rng(np.random.randint(2**31, size=4))
        goals = draw_goals(self._goals, len(batch_inds), random)
        now, after = self.observations[places], self.next_observations[places]
        now[:, self._columns] = after[:, self._columns] = goals.scaled()
        strokes = self.strokes[places].astype(np.float64)
        speed, topspin, returned = strokes[:, 2:].T
        of_goals = goal_reward(strokes[:, :2], speed, topspin, returned == 1, goals)
        rewards = self.rewards[places] + np.nan_to_num(of_goals)
        parts = (now, self.actions[places], after, _column(self.dones[places]), _column(rewards))
        return ReplayBufferSamples(*(self.to_torch(part) for part in parts))


def _stroke(info: dict[str, Any]) -> tuple[float, ...]:
    if not info.get("hit"):
        return _NO_STROKE
    return (*info["landing"], info["speed"], info["topspin"], info["returned"])


def _column(values: Floats) -> NDArray[np.float32]:
    return values.astype(np.float32)[:, None]
