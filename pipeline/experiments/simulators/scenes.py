"""The scenes: each has the hidden physics as far as its engine can state it, but for one thing."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import mujoco
import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.engines.engine import Engine, FunctionEngine
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.engines.export.code import ball_effects
from rallygap.pipeline.engines.export.code_engine import CodeEngine, steps_of
from rallygap.pipeline.engines.load import module_of_file
from rallygap.pipeline.runtime.paths import repository_root

# The hidden physics.
TRUTH = Simulator.from_dict(
    {
        "gravity": {"g": 9.81},
        "drag": {"cd": 0.47},
        "magnus": {"cm": 0.12},
        "wind": {"x": 0.1, "y": -0.15},
        "table_bounce": {"restitution": 0.92, "friction": 0.25},
    }
)
EXAMPLE = "docs/examples/pybullet_ball.py"

MJCF = """<mujoco model="table tennis">
  <option timestep="{step}" integrator="{integrator}" density="{density}" viscosity="{viscosity}"
    wind="{wind}" gravity="{gravity}"/>
  <worldbody>
    <geom name="table" type="box" size=".7625 1.37 .0125" pos="0 0 -.0125"/>
    <body name="ball" pos="0 0 .5">
      <freejoint/>
      <geom name="ball" type="sphere" size=".02" mass=".0027" {shell} fluidshape="ellipsoid"
        fluidcoef="{drag} 0 0 0 {lift}" solref="{solref}" solimp=".98 .98 .001"
        friction="{friction} .005 .0001"/>
    </body>
  </worldbody>
</mujoco>
"""
RIGHT = {
    "step": "0.0005",
    "integrator": "RK4",
    "density": "1.2",
    "viscosity": "0",
    "wind": "0.1 -0.15 0",
    "gravity": "0 0 -9.81",
    "shell": 'shellinertia="true"',
    "drag": "0.235",
    "lift": "0.62",
    "solref": "-1000000 -53",
    "friction": "0.25",
}


@dataclass(frozen=True)
class HiddenScene:
    """A scene with something wrong.

    Attributes:
        engine: ``mujoco`` or ``pybullet``.
        name: of the scene.
        hidden: what is wrong, in words.
        causes: parameters, any of which among the leading causes is right.
        changes: of what is right, by name.
    """

    engine: str
    name: str
    hidden: str
    causes: tuple[str, ...]
    changes: Mapping[str, Any]

    def build(self) -> Engine:
        """Return the scene as an engine."""
        if self.engine == "mujoco":
            return self._scene()
        module = self._module()
        return FunctionEngine("pybullet", lambda states, times: np.array(module.fly(states, times)))

    def fly_amended(self, simulator: Simulator, states: Floats, times: Floats) -> Floats:
        """Return (B, T, 9) states of balls that the code of a simulator flies in the engine."""
        code = ball_effects(simulator, self.name, [], self.engine)
        if self.engine == "mujoco":
            return CodeEngine(self.name, code, self._scene()).fly(states, times)
        import pybullet

        names: dict[str, Any] = {}
        exec(code, names)
        module = self._module()
        client = pybullet.connect(pybullet.DIRECT)
        try:
            body, table = module.world(client)
            ball = names["Ball"](body, table, module.STEP, client=client)
            return np.array([steps_of(ball, state, times, module.STEP) for state in states])
        finally:
            pybullet.disconnect(client)

    def _scene(self) -> MujocoScene:
        text = MJCF.format(**{**RIGHT, **self.changes})
        return MujocoScene.of(self.name, mujoco.MjModel.from_xml_string(text))

    def _module(self) -> ModuleType:
        """Return the example of PyBullet with other values of its constants."""
        module = module_of_file(repository_root() / EXAMPLE)
        for name, value in self.changes.items():
            setattr(module, name, value)
        return module


def scenes() -> Iterator[HiddenScene]:
    """Yield all scenes."""
    for engine, rows in (("mujoco", MUJOCO), ("pybullet", PYBULLET)):
        for row in rows:
            yield HiddenScene(engine, *row)


_Row = tuple[str, str, tuple[str, ...], Mapping[str, Any]]
_DRAG, _LIFT = ("drag.cd",), ("magnus.cm",)
_RESTITUTION, _FRICTION = ("table_bounce.restitution",), ("table_bounce.friction",)

MUJOCO: tuple[_Row, ...] = (
    ("drag", "C_D .30 instead of .47", _DRAG, {"drag": "0.15"}),
    ("drag_twice", "C_D written as the first number of fluidcoef", _DRAG, {"drag": "0.47"}),
    ("vacuum", "no density", _DRAG, {"density": "0"}),
    ("natural_lift", "C_M written as the fifth number of fluidcoef", _LIFT, {"lift": "0.12"}),
    ("no_lift", "fifth number of fluidcoef .5", _LIFT, {"lift": "0.5"}),
    ("large_lift", "fifth number of fluidcoef 1, the default", _LIFT, {"lift": "1"}),
    ("wind", "a draught of .5 m/s the other way", ("wind.x",), {"wind": "-0.4 -0.15 0"}),
    ("tilt", "gravity a degree off", ("frame_tilt.x",), {"gravity": "0.171 0 -9.8085"}),
    ("restitution", "restitution .80", _RESTITUTION, {"solref": "-1000000 -141"}),
    ("soft", "the default contact, restitution .135", _RESTITUTION, {"solref": "0.02 1"}),
    ("friction", "friction .05", _FRICTION, {"friction": "0.05"}),
    ("solid", "a solid sphere", _FRICTION, {"shell": ""}),
    ("viscosity", "drag in proportion to speed", ("linear_drag.k1",), {"viscosity": "0.0022"}),
    ("euler", "Euler's integrator with steps of 4 ms", ("gravity.g",),
     {"integrator": "Euler", "step": "0.004"}),
)  # fmt: skip
PYBULLET: tuple[_Row, ...] = (
    ("vacuum", "no air", _DRAG, {"DRAG": 0.0, "LIFT": 0.0}),
    ("no_lift", "no lift", _LIFT, {"LIFT": 0.0}),
    ("damping", "the default damping", ("linear_drag.k1", "drag.cd"), {"DAMPING": 0.04}),
    ("restitution", "restitution .75", _RESTITUTION, {"RESTITUTION": 0.75}),
)
