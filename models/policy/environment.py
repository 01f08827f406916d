"""The training environment for Stable-Baselines3."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvStepReturn

from rallygap.models.ball.types import Bools, Floats
from rallygap.models.policy.batch_simulation import ACTIONS, BatchSimulation
from rallygap.models.policy.episodes import OUTCOMES, STYLE, Episodes
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.incoming_balls import IncomingBalls
from rallygap.models.policy.observation import LIMIT, Observations, observation_size
from rallygap.models.policy.task import Task

BATCH = 256  # balls generated at once, which makes a new episode cheap

# In the info of an ended episode, with its landing, its goal and its ball's number.
REPORTED = (*OUTCOMES, *STYLE, "goal_reward")


class ReturnVecEnv(VecEnv):
    """Parallel environments, each reset with the next ball when its episode ends.

    The info of an episode's last step has fields of ``Episodes`` (``REPORTED`` and ``landing``),
    its goals (``goal_landing``, and ``goal_speed`` and ``goal_topspin`` where set), the number
    of its ``ball`` since the seed was set, and the ``terminal_observation``. Balls are handed out
    in the order in which environments become free, so all results follow from the seed and the
    actions.
    """

    def __init__(self, task: Task, count: int, seed: int) -> None:
        """Set up ``count`` environments; ``seed`` is that of the first reset."""
        self.render_mode = None
        size = observation_size(len(task.horizons), task.goals.count, task.observation)
        observed = spaces.Box(-LIMIT, LIMIT, (size,), np.float32)
        super().__init__(count, observed, spaces.Box(-1.0, 1.0, (ACTIONS,), np.float32))
        self._simulation = BatchSimulation(
            task.simulator, count, task.observation, weights=task.reward
        )
        self._task = task
        self._random: np.random.Generator
        self._waiting: tuple[IncomingBalls, Goals]  # balls that were drawn at once
        self._balls = np.zeros(count, dtype=np.int64)  # that environments have, by their numbers
        self._handed_out = 0
        self._actions: NDArray[np.floating]
        self.seed(seed)

    def reset(self) -> Observations:
        """Start episodes with the next balls, or with the first balls of a seed that was set."""
        if self._seeds[0] is not None:
            self._random, self._handed_out = np.random.default_rng(self._seeds[0]), 0
            self._waiting = self._draw()
        self._reset_seeds()
        self._reset_options()
        self._start_episodes(np.ones(self.num_envs, dtype=np.bool_))
        return self._simulation.observe()

    def _draw(self) -> tuple[IncomingBalls, Goals]:
        return self._task.draw(max(BATCH, self.num_envs), self._random)

    def _start_episodes(self, which: Bools) -> None:
        """Start new episodes in the environments of ``which`` (B,)."""
        free = np.flatnonzero(which)
        while len(free):
            if not len(self._waiting[0]):
                self._waiting = self._draw()
            incoming, goals = self._waiting
            served, free = free[: len(incoming)], free[len(incoming) :]
            given = np.isin(np.arange(self.num_envs), served)
            self._simulation.reset(given, incoming[: len(served)], goals[: len(served)])
            self._waiting = incoming[len(served) :], goals[len(served) :]
            self._balls[served] = self._handed_out + np.arange(len(served))
            self._handed_out += len(served)

    def step_async(self, actions: NDArray[np.floating]) -> None:
        """Store the actions of the next control step."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Simulate one control step, and reset environments whose episodes ended."""
        step = self._simulation.step(self._actions)
        observation = step.observation
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for row, env in enumerate(step.ended.envs):
            infos[env] = {
                **_report(step.ended, row),
                "ball": int(self._balls[env]),
                "terminal_observation": step.observation[env],
                "TimeLimit.truncated": False,
            }
        if len(step.ended.envs):
            self._start_episodes(step.done)
            observation = self._simulation.observe()
        return observation, step.reward.astype(np.float32), step.done, infos

    def following_actions(self, random: np.random.Generator) -> Floats:
        """Return (B, 5) actions that follow the balls, for the warm-up of a training."""
        return self._simulation.following_actions(random)

    def close(self) -> None:
        """Release the Bullet world."""
        self._simulation.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute, which all environments share."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Raise NotImplementedError: environments have no attributes of their own."""
        raise NotImplementedError("environments have no attributes of their own")

    def env_method(
        self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any
    ) -> list[Any]:
        """Raise NotImplementedError: environments have no methods of their own."""
        raise NotImplementedError("environments have no methods of their own")

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper], indices: VecEnvIndices = None
    ) -> list[bool]:
        """Return that no environment is wrapped."""
        return [False for _ in self._get_indices(indices)]


def _report(ended: Episodes, row: int) -> dict[str, Any]:
    """Return how an episode ended, and its goals."""
    info = {name: getattr(ended, name)[row].item() for name in REPORTED}
    goals = {
        f"goal_{name}": column[row]
        for name, column in vars(ended.goals).items()
        if column is not None
    }
    return {**info, **goals, "landing": ended.landing[row]}
