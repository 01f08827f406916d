"""Scenes of MuJoCo, written from what differs between them."""

import mujoco

from rallygap.models.engines.mujoco.scene import MujocoScene

BALL = 'type="sphere" size=".02" mass=".0027"'
SHELL = 'shellinertia="true"'
HARD = 'solref="-1000000 -47" solimp=".98 .98 .001"'
CONTACT = f'{HARD} friction=".25 .005 .0001"'
TABLE = '<geom name="top" type="box" size=".7625 1.37 .0125" pos="0 0 -.0125"/>'


def air(drag: float = 0.0, lift: float = 0.0, spin: float = 0.0) -> str:
    """Attributes of a ball with coefficients of drag and lift, and a damping of its spin."""
    return f'fluidshape="ellipsoid" fluidcoef="{drag / 2} 0 {spin} 0 {lift + 0.5}"'


def ball(geom: str = f"{BALL} {SHELL}", name: str = "ball", joint: str = "<freejoint/>") -> str:
    return f'<body name="{name}" pos="0 0 .5">{joint}<geom {geom}/></body>'


def written(world: str, option: str = "", rest: str = "") -> str:
    return f"<mujoco><option {option}/><worldbody>{world}</worldbody>{rest}</mujoco>"


def compiled(world: str, option: str = "", rest: str = "") -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(written(world, option, rest))


def pair(attributes: str, cone: str = "elliptic") -> str:
    """A contact of the table with the ball that has its own friction."""
    return (
        f'<option cone="{cone}"/><contact><pair geom1="top" geom2="sphere" condim="3" '
        f"{attributes}/></contact>"
    )


def scene(
    geom: str = "",
    option: str = "",
    table: str = TABLE,
    rest: str = "",
    *,
    body: str = "",
    joint: str = "",
    size: str = 'size=".02" mass=".0027"',
) -> MujocoScene:
    """A ball over a table, flown with RK4 at 1 ms unless ``option`` says otherwise."""
    attributes = option if "timestep" in option else f'timestep=".001" {option}'
    attributes = attributes if "integrator" in attributes else f'integrator="RK4" {attributes}'
    world = (
        f'{table}<body name="ball" pos="0 0 .5" {body}><joint type="free" {joint}/>'
        f'<geom name="sphere" type="sphere" {size} {geom}/></body>'
    )
    return MujocoScene.of("scene", compiled(world, attributes, rest))
