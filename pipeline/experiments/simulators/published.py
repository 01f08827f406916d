"""Published models of table tennis, as minimal scenes with their parameters.

The parameters are facts that were read in the files that are named; no file is copied. What a file
does not say, such as a table of another shape, is ours.
"""

from dataclasses import dataclass

import mujoco

from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.engine import EffectsEngine, Engine
from rallygap.models.engines.mujoco.scene import MujocoScene

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
    """A published model.

    Attributes:
        name: of the project.
        file: with the parameters.
        says: these parameters, in short.
        scene: of MuJoCo; None for another engine.
        effects: the model as a list, where it is of another engine.
        bounces: whether the file says how the ball bounces; if not, there is no table here.
    """

    name: str
    file: str
    says: str
    scene: str | None
    effects: Simulator | None = None
    bounces: bool = True

    def build(self) -> Engine:
        """Return the model as an engine."""
        if self.scene is None:
            assert self.effects is not None  # of another engine
            return EffectsEngine(self.name, self.effects)
        return self.scene_of_mujoco()

    def scene_of_mujoco(self) -> MujocoScene:
        """Return the scene of a model of MuJoCo."""
        assert self.scene is not None  # of MuJoCo
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
        None,
        Simulator.from_dict(
            {
                "gravity": {"g": 9.81},
                "drag": {"cd": 0.4378},
                "table_bounce": {"restitution": 0.8, "friction": 0.1},
            }
        ),
    ),
)
