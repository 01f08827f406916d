"""The ball of ``ball_effects.py`` in its scene, as an engine."""

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.engines.mujoco.initial import reset
from rallygap.models.engines.mujoco.log import collected_warnings
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.engines.export.flown import flown


@dataclass(frozen=True)
class CodedBall:
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

        Args:
            states: (B, 9) at time zero, in the table frame.
            times: (T,) s, rising, multiples of the scene's time step.

        Returns:
            (B, T, 9) states.
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
                paths.append(flown(ball, state, times, float(model.opt.timestep)))
        return np.array(paths)
