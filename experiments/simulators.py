"""Scenes of other engines: published models, scenes with something wrong, and larger spins."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

import mujoco
import numpy as np

from rallygap.models.arena.levels import Players
from rallygap.models.arena.rallies import Rallies
from rallygap.models.arena.truth import draw_truth
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN
from rallygap.models.ball.types import Floats
from rallygap.models.engines.engine import EffectsEngine, Engine, FunctionEngine
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.engines.export.code import ball_effects
from rallygap.pipeline.engines.export.code_engine import CodeEngine, steps_of
from rallygap.pipeline.engines.load import module_of_file
from rallygap.pipeline.runtime.paths import repository_root

SCENE = """<mujoco>
  <option timestep="0.002" integrator="RK4" cone="elliptic" {option}/>
  <worldbody>
    {table}
    <body name="ball" pos="0 0 .5">
      <freejoint/>
      <geom name="ball" type="sphere" size=".02" mass=".0027" fluidshape="ellipsoid" {geom}/>
    </body>
  </worldbody>
  {contact}
</mujoco>
"""
TABLE = '<geom name="table" type="box" size=".7625 1.37 .0125" pos="0 0 -.0125"/>'
PAIR = """<contact><pair geom1="ball" geom2="table" condim="3" solref="-1000000 -17"
    friction=".1 .1 .005 .0001 .0001" solreffriction="0 -200"/></contact>"""


@dataclass(frozen=True)
class PublishedModel:
    """A published model as a minimal scene with its parameters.

    The parameters are facts that were read in the file that is named; no file is copied. What it
    does not say, such as a table of another shape, is ours.

    Attributes:
        name: of the project.
        file: with the parameters.
        says: these parameters, in short.
        scene: of MuJoCo, or a list of effects for another engine.
        bounces: whether the file says how the ball bounces; if not, there is no table here.
    """

    name: str
    file: str
    says: str
    scene: str | Simulator
    bounces: bool = True

    def build(self) -> Engine:
        """Return the model as an engine."""
        if isinstance(self.scene, Simulator):
            return EffectsEngine(self.name, self.scene)
        return MujocoScene.of(self.name, mujoco.MjModel.from_xml_string(self.scene))


def _scene(option: str, geom: str, table: str = TABLE, contact: str = "") -> str:
    return SCENE.format(option=option, geom=geom, table=table, contact=contact)


PUBLISHED = (
    PublishedModel(
        "google-deepmind/competitive_robot_table_tennis",
        "ball_states_viz.ipynb",
        "density 1.225, fluidcoef .235 .25 0 1 1; pair: solref -1e6 -17, friction .1, "
        "solreffriction 0 -200",
        _scene('density="1.225"', 'fluidcoef=".235 .25 0 1 1"', contact=PAIR),
    ),
    PublishedModel(
        "MyoHub/myosuite",
        "myoarm_tabletennis.xml",
        "fluidcoef .235 .25 0 1 1, solref -80000 -1",
        _scene("", 'fluidcoef=".235 .25 0 1 1" solref="-80000 -1"'),
    ),
    PublishedModel(
        "xSpaceCoder/DeepLearningTennis3DUplift",
        "the scene of its simulation",
        "fluidcoef .6 .6 .6 1 .2",
        _scene('density="1.225"', 'fluidcoef=".6 .6 .6 1 .2"', table=""),
        bounces=False,
    ),
    PublishedModel(
        "purdue-tracelab/TTRL-ICRA2026",
        "its Isaac environment",
        "C_D .4378, restitution min(.8, .9), friction .1, no lift",
        Simulator.from_dict(
            {
                "gravity": {"g": 9.81},
                "drag": {"cd": 0.4378},
                "table_bounce": {"restitution": 0.8, "friction": 0.1},
            }
        ),
    ),
)

# The hidden physics: scenes have it as far as their engine can state it, but for one thing.
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

# The arena's amateur and club levels follow published launches, whose spins were fitted about a
# simulator with several times the lift of a real ball. If that made them too small, players spin
# the ball more than the levels do.
LEVELS, FACTORS = ("amateur", "club"), (1.0, 1.7)
POINTS = 2000
SEED = 1001  # of a world and its games; not of the arena
SPINS = ("topspin", "attack_topspin", "sidespin", "serve_spin")  # traits
AHEAD = 0.4  # s
MM = 1e3


def larger_spins() -> dict[str, list[dict[str, Any]]]:
    """Return what games are like, by level, a record for each factor on the spins."""
    return {level: [_game(level, factor) for factor in FACTORS] for level in LEVELS}


def _game(level: str, factor: float) -> dict[str, Any]:
    truth, random = draw_truth(SEED), np.random.default_rng(SEED)
    players = Players.draw(level, 2 * POINTS, random)
    spun = replace(players, **{name: factor * getattr(players, name) for name in SPINS})
    log = Rallies(truth, spun, random.integers(2, size=POINTS), random).play()
    points, contacts = log.contacts()
    struck = contacts.kinds == "racket"
    points, launches = points[struck], contacts.states[struck]
    launches = launches[1:][points[1:] == points[:-1]]  # of strokes that are no serves
    sizes = np.linalg.norm(launches[:, SPIN], axis=1)
    ends, counts = np.unique(log.ended_by, return_counts=True)
    shares = counts / counts.sum()
    return {
        "factor": factor,
        "strokes": len(launches),
        "spin_median": round(float(np.median(sizes)), 1),
        "spin_p95": round(float(np.quantile(sizes, 0.95)), 1),
        "bend_mm": round(MM * float(np.median(bends(truth.simulator, launches))), 1),
        "strokes_a_point": round(float(log.strokes.mean()), 2),
        "ended_by": {
            str(name): round(float(share), 3) for name, share in zip(ends, shares, strict=True)
        },
    }


def bends(simulator: Simulator, launches: Floats) -> Floats:
    """Return by how much lift moves each ball, m, after ``AHEAD`` in free flight."""
    air = simulator.without_surfaces()
    pair = air, air.amended("magnus", cm=0.0)
    flown, straight = (law.fly(launches, [AHEAD]).states[:, 0, POSITION] for law in pair)
    return np.linalg.norm(flown - straight, axis=1)
