"""A Gymnasium wrapper: the ball of a MuJoCo environment flies as ball_effects.py says.

    from ball_effects import Ball
    from gymnasium_ball import AmendedBall

    env = AmendedBall(MyEnv(), Ball, body="ball", origin=(0.0, 0.0, 0.76))

Copy this file and ball_effects.py (``rallygap export --to mujoco``) into the folder of your own.
"""

from collections.abc import Callable
from typing import Any

import gymnasium
import mujoco
import numpy as np
from numpy.typing import NDArray


class AmendedBall(gymnasium.Wrapper):
    """An environment whose ball flies and bounces by another model; all else is as before.

    It replaces ``do_simulation`` of the environment itself, so that observations and rewards are
    of the amended ball. For the scene as it is, make another environment. The ball has no state but
    that of the scene, so a reset is the environment's alone; it may load its scene again.

    Args:
        env: its unwrapped environment has ``model`` and ``data`` of MuJoCo and simulates in
            ``do_simulation(ctrl, n_frames)`` alone, as ``gymnasium.envs.mujoco.MujocoEnv`` does.
        ball: the class ``Ball`` of ball_effects.py.
        place: arguments of ``Ball``: ``body`` (its name), ``origin`` (m) and ``axes`` of the table.

    Raises:
        TypeError: the environment is not such a one.
        KeyError: the scene has no such body.
    """

    def __init__(self, env: gymnasium.Env, ball: Callable[..., Any], **place: Any) -> None:
        super().__init__(env)
        self._ball, self._place = ball, place
        scene = self.unwrapped
        name = type(scene).__name__
        if not isinstance(getattr(scene, "model", None), mujoco.MjModel):
            raise TypeError(f"{name} has no scene of MuJoCo in `model` and `data`")
        if not hasattr(scene, "do_simulation"):
            raise TypeError(
                f"{name} has no `do_simulation(ctrl, n_frames)`; in your own environment, call "
                "`step` of a Ball instead of `mujoco.mj_step`"
            )
        self._new_ball()  # the body's name is checked
        scene.do_simulation = self._simulate

    def _simulate(self, ctrl: NDArray[np.floating], n_frames: int) -> None:
        """Simulate time steps of the scene with the (A,) controls of its actuators."""
        scene = self.unwrapped
        scene.data.ctrl[:] = ctrl
        ball = self._new_ball()
        for _ in range(n_frames):
            ball.step()
        # As MujocoEnv does: forces of contacts, which some observations have.
        mujoco.mj_rnePostConstraint(scene.model, scene.data)

    def _new_ball(self) -> Any:
        """Return the ball in the scene that the environment has now."""
        return self._ball(self.unwrapped.model, self.unwrapped.data, **self._place)
