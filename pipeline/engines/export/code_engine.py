"""The ball of a ``ball_effects.py`` as an engine, in a scene of MuJoCo."""

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.models.engines.mujoco.simulation import collected_warnings, reset


@dataclass(frozen=True)
class CodeEngine:
    """A scene whose ball the code flies.

    Attributes:
        name: for errors.
        code: content of ``ball_effects.py`` for MuJoCo.
        scene: with its integrator and its time step.
    """

    name: str
    code: str
    scene: MujocoScene

    def fly(self, states: Floats, times: Floats) -> Floats:
        """Fly balls, each from the start of the scene, as ``Engine`` does.

        Times are multiples of the scene's time step.
        """
        names: dict[str, Any] = {}
        exec(self.code, names)
        model, frame = self.scene.model, self.scene.frame
        data = mujoco.MjData(model)
        axes = [tuple(axis) for axis in frame.axes.T.tolist()]
        place = self.scene.ball.body, tuple(frame.origin.tolist()), axes
        ball = names["Ball"](model, data, *place)
        paths = []
        with collected_warnings():
            for state in states:
                reset(model, data)
                paths.append(steps_of(ball, state, times, float(model.opt.timestep)))
        return np.array(paths)


def steps_of(ball: Any, state: Floats, times: Floats, step: float) -> list[tuple[float, ...]]:
    """Return the T states of a ``Ball`` of the code, in whatever engine it is.

    Args:
        ball: in any engine.
        state: (9,) at time zero.
        times: (T,) s, rising, multiples of the step.
        step: s, of the engine.
    """
    marks = np.rint(times / step).astype(int).tolist()
    ball.set(tuple(state.tolist()))
    path = []
    for number in range(1, marks[-1] + 1):
        ball.step()
        if number in marks:
            path.append(ball.state())
    return path
