"""Scenes to be amended, and lists of effects for them."""

from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.mujoco.stated import stated_effects
from rallygap.pipeline.engines.export.scene.amendment import SceneFile, amend

SCENE = """<?xml version="1.0"?>
<!-- A table. <option wind="9 9 9"/> and <geom name="ball"/> are not here -- and stay. -->
<mujoco model='lab'>
  <option timestep = "0.001"   integrator="RK4" density='1.2'
          gravity="0 0 -9.81" />  <!-- tuned by hand -->
  <worldbody>
    <geom name="table" type="box" size="1.37 .7625 .0125" pos="1 2 .7475" friction="0 0 0"/>
    <body name="robot" pos="5 5 1"><geom size=".1"/></body>
    <body name="ball" pos="0 0 1.5">
      <freejoint/>
      <geom name='ball' type="sphere" size=".02" mass=".0027" shellinertia="true"
            fluidshape="ellipsoid" fluidcoef='.15 0 0 0 .55'
            solref="-1000000 -30" solimp=".98 .98 .001" friction="0 0 0"/>
    </body>
  </worldbody>
</mujoco>
"""
POST = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"  # a mesh
PLAIN = """<mujoco>{head}<worldbody>
<geom type="box" size=".7625 1.37 .0125" pos="0 0 -.0125" friction="0 0 0"/>
<body name="ball" pos="0 0 .5"><freejoint/>
<geom type="sphere" size=".02" {ball}/></body></worldbody>{rest}</mujoco>"""


def plain(ball='mass=".0027" shellinertia="true" friction="0 0 0"', head="", rest=""):
    """A scene with the defaults of MuJoCo."""
    return PLAIN.format(ball=ball, head=head, rest=rest)


def file_of(folder, text):
    """The scene as a file."""
    path = folder / "lab.xml"
    path.write_bytes(text.encode())
    return SceneFile.read(str(path))


def does(file):
    """The list that a scene's attributes stand for."""
    return Simulator.from_dict(stated_effects(file.scene()))


def changed(file, changes):
    """The same list with changes, such as ``{"drag": {"cd": 0.5}}``."""
    after = does(file)
    for effect, values in changes.items():
        after = after.amended(effect, **values)
    return after


class Amended:
    """A scene that states one list, amended so that it states another."""

    def __init__(self, file, after, comments=()):
        self.before, self.after = does(file), after
        amendments = amend(file, self.before, after, comments)
        self.sentences = [amendment.sentence for amendment in amendments]
        self.changes = tuple(dict.fromkeys(amendment.attribute for amendment in amendments))
        self.text, self.scene = file.text(self.sentences), file.written()


def amended(folder, text, changes, comments=()):
    """The scene of a text amended with changes of what it states."""
    file = file_of(folder, text)
    return Amended(file, changed(file, changes), comments)
