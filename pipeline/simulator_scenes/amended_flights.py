"""Amended balls flown in their own engines, by the code that is given back."""

from typing import Any

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.pipeline.engines.export.code import ball_effects
from rallygap.pipeline.engines.export.flown import flown
from rallygap.pipeline.simulator_scenes.scenes import HiddenScene, pybullet_module


def amended_flights(
    scene: HiddenScene, amended: Simulator, states: Floats, times: Floats
) -> Floats:
    """Return (B, T, 9) states of balls that the amended code flies in the scene's engine."""
    from rallygap.pipeline.engines.export.scene.coded_ball import CodedBall

    code = ball_effects(amended, scene.name, [], scene.engine)
    if scene.engine == "mujoco":
        return CodedBall(scene.name, code, scene.scene()).fly(states, times)
    return _in_pybullet(scene, code, states, times)


def _in_pybullet(scene: HiddenScene, code: str, states: Floats, times: Floats) -> Floats:
    import pybullet

    names: dict[str, Any] = {}
    exec(code, names)
    module = pybullet_module(scene.changes)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body, table = module.world(client)
        ball = names["Ball"](body, table, module.STEP, client=client)
        return np.array([flown(ball, state, times, module.STEP) for state in states])
    finally:
        pybullet.disconnect(client)
