"""The environment in which policies learn, as Gymnasium has it and as Stable-Baselines3 does."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvStepReturn

from models.ball.simulator import Simulator
from models.policy.ball_supply import Supply
from models.policy.batch_simulation import ACTIONS, Court
from models.policy.episodes import Episodes
from models.policy.incoming_balls import Balls
from models.policy.observation import LIMIT, Observations, observation_size
from models.policy.settings import ObservationKind

Integers = NDArray[np.int64]

# What the info of an ended episode says of it, next to its landing, its goal and its ball.
REPORTED = (
    "hit",
    "returned",
    "fault",
    "goal_reward",
    "nearest",
    "time",
    "backhand",
    "distance",
    "net_height",
    "speed",
    "topspin",
)


class ReturnEnv(gymnasium.Env[Observations, NDArray[np.float32]]):
    """One arm that returns one ball an episode.

    The info of an episode's last step has what ``Episodes`` knows of it (``REPORTED``, and
    ``landing``), its goals (``goal_landing``, where asked for ``goal_speed`` and ``goal_topspin``)
    and the number of its ``ball`` since the seed was set.
    """

    def __init__(self, simulator: Simulator, balls: Balls, kind: ObservationKind) -> None:
        """Set up the environment.

        Args:
            simulator: flies the balls on from the racket.
            balls: where the balls come from.
            kind: what the policy sees.
        """
        self.observation_space, self.action_space = _spaces(balls, kind)
        self._court, self._balls = Court(simulator, 1, kind), balls
        self._supply: Supply | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Begin with the next ball, or with the first that comes of a seed."""
        super().reset(seed=seed)
        if self._supply is None or seed is not None:
            self._supply = Supply(self._balls, 1, self.np_random)
        self._supply.serve(self._court, np.ones(1, dtype=np.bool_))
        return self._court.observe()[0], {}

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observations, float, bool, bool, dict[str, Any]]:
        """Let one tick pass."""
        if self._supply is None:
            raise gymnasium.error.ResetNeeded("call reset before the first step")
        step = self._court.step(action[None])
        done = bool(step.done[0])
        info = _report(step.ended, 0, self._supply.numbers) if done else {}
        return step.observation[0], float(step.reward[0]), done, False, info

    def close(self) -> None:
        """Give the arm's world back."""
        self._court.close()


class ReturnVecEnv(VecEnv):
    """Many arms, each of which gets its next ball by itself when its episode ends.

    Infos are those of ``ReturnEnv``, with the ``terminal_observation``. Balls go to the arms in the
    order in which these become free, so that everything follows from the seed and the actions.
    """

    def __init__(
        self, simulator: Simulator, balls: Balls, kind: ObservationKind, count: int, seed: int
    ) -> None:
        """Set up the environment.

        Args:
            simulator: flies the balls on from the rackets.
            balls: where the balls come from.
            kind: what the policy sees.
            count: arms.
            seed: of the first reset; ``seed`` sets that of the next.
        """
        self.render_mode = None
        super().__init__(count, *_spaces(balls, kind))
        self._court, self._balls = Court(simulator, count, kind), balls
        self._supply: Supply
        self._actions: NDArray[np.floating]
        self.seed(seed)

    def reset(self) -> Observations:
        """Begin with the next balls, or with the first that come of a seed that was set."""
        if self._seeds[0] is not None:
            random = np.random.default_rng(self._seeds[0])
            self._supply = Supply(self._balls, self.num_envs, random)
        self._reset_seeds()
        self._reset_options()
        self._supply.serve(self._court, np.ones(self.num_envs, dtype=np.bool_))
        return self._court.observe()

    def step_async(self, actions: NDArray[np.floating]) -> None:
        """Take the actions of the next tick."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Let one tick pass, and hand out balls where episodes ended."""
        step = self._court.step(self._actions)
        observation = step.observation
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for row, arm in enumerate(step.ended.arms):
            infos[arm] = _report(step.ended, row, self._supply.numbers)
            infos[arm]["terminal_observation"] = step.observation[arm]
            infos[arm]["TimeLimit.truncated"] = False
        if len(step.ended.arms):
            self._supply.serve(self._court, step.done)
            observation = self._court.observe()
        return observation, step.reward.astype(np.float32), step.done, infos

    def close(self) -> None:
        """Give the arms' world back."""
        self._court.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute, which all arms have in common."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Refuse: the arms have no attributes of their own."""
        raise NotImplementedError("the arms have no attributes of their own")

    def env_method(
        self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any
    ) -> list[Any]:
        """Refuse: the arms have no methods of their own."""
        raise NotImplementedError("the arms have no methods of their own")

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper], indices: VecEnvIndices = None
    ) -> list[bool]:
        """Return that no single arm is wrapped."""
        return [False for _ in self._get_indices(indices)]


def _spaces(
    balls: Balls, kind: ObservationKind
) -> tuple["spaces.Box[np.float32]", "spaces.Box[np.float32]"]:
    """Return the spaces of observations and actions; one ball shows how large they are."""
    incoming, goals = balls(1, np.random.default_rng(0))
    size = observation_size(incoming.forecasts.shape[2], goals.scaled().shape[1], kind)
    seen = spaces.Box(-LIMIT, LIMIT, (size,), np.float32)
    return seen, spaces.Box(-1.0, 1.0, (ACTIONS,), np.float32)


def _report(ended: Episodes, row: int, numbers: Integers) -> dict[str, Any]:
    """Return the info of an episode that ended."""
    info = {name: getattr(ended, name)[row].item() for name in REPORTED}
    asked = {
        f"goal_{name}": column[row]
        for name, column in vars(ended.goals).items()
        if column is not None
    }
    return {**info, **asked, "landing": ended.landing[row], "ball": int(numbers[ended.arms[row]])}
