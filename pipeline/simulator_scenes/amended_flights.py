"""Amended balls flown in their own engines, by the code that is given back."""

from typing import Any

import numpy as np

from models.ball.simulator import Simulator
from models.ball.types import Floats
from pipeline.engines.export.code import ball_effects
from pipeline.simulator_scenes.scenes import HiddenScene, pybullet_module


def amended_flights(
    scene: HiddenScene, amended: Simulator, states: Floats, times: Floats
) -> Floats:
    """Return (B, T, 9) states of balls that the amended code flies in the scene's engine."""
    names: dict[str, Any] = {}
    exec(ball_effects(amended, scene.name, [], scene.engine), names)
    if scene.engine == "mujoco":
        return _in_mujoco(scene, names["Ball"], states, times)
    return _in_pybullet(scene, names["Ball"], states, times)


def _in_mujoco(scene: HiddenScene, kind: Any, states: Floats, times: Floats) -> Floats:
    import mujoco

    built = scene.scene()
    data = mujoco.MjData(built.model)
    axes = [tuple(axis) for axis in built.frame.axes.T.tolist()]
    ball = kind(built.model, data, built.ball.name, tuple(built.frame.origin.tolist()), axes)
    return _flown(ball, states, times, float(built.model.opt.timestep))


def _in_pybullet(scene: HiddenScene, kind: Any, states: Floats, times: Floats) -> Floats:
    import pybullet

    module = pybullet_module(scene.changes)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body, table = module.world(client)
        ball = kind(body, table, module.STEP, client=client)
        return _flown(ball, states, times, module.STEP)
    finally:
        pybullet.disconnect(client)


def _flown(ball: Any, states: Floats, times: Floats, step: float) -> Floats:
    marks = np.rint(times / step).astype(int)
    flown = []
    for state in states:
        ball.set(tuple(state.tolist()))
        path = []
        for number in range(1, int(marks[-1]) + 1):
            ball.step()
            if number in marks:
                path.append(ball.state())
        flown.append(path)
    return np.array(flown)
