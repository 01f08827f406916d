"""What scenes state: a list of effects that flies as they do, and notes."""

import math

import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.mujoco.notes import scene_notes
from rallygap.models.engines.mujoco.stated import stated_effects
from tests.models.engines.mujoco.scenes import SHELL, TABLE, air, pair, scene
from tests.models.engines.mujoco.test_scene import BALLS, FLIGHT, STILL

STIFF = 'solref="-16000000 -150"'
OWN = f'{STIFF} friction=".2 .2 0 0 0"'
FRICTIONLESS = f'{STIFF} condim="1"'
CLEAN = f"{SHELL} {air(0.47, 0.12)} {FRICTIONLESS}"
GRIPPING = f'{SHELL} {air(0.47, 0.12)} {STIFF} condim="3"'
FAST = f'{SHELL} {air(0.47, 0.12)} solref=".00005 .1" condim="1" priority="1"'
PLAIN = 'density="1.2" timestep=".00005"'
LEVEL = TABLE.replace("/>", ' condim="1"/>')
TURNED = LEVEL.replace('pos="0 0 -.0125"', 'pos="1 2 .7475" euler="0 0 110"')


def notes_of(geom=CLEAN, option=PLAIN, table=LEVEL, **more):
    return "; ".join(scene_notes(scene(geom, option, table, **more)))


def test_a_scene_without_surprises_has_no_notes():
    assert notes_of() == ""
    effects = stated_effects(scene(CLEAN, PLAIN, LEVEL))
    assert list(effects) == ["gravity", "drag", "magnus", "table_bounce"]
    assert effects["drag"]["cd"] == pytest.approx(0.47)
    assert effects["magnus"]["cm"] == pytest.approx(0.12, abs=1e-6)
    assert effects["table_bounce"] == pytest.approx({"restitution": 0.943, "friction": 0}, abs=1e-3)


@pytest.mark.parametrize(
    ("geom", "option", "table", "balls", "more"),
    [
        (CLEAN, 'density="1.225"', LEVEL, BALLS, {}),
        (CLEAN, 'density="1.2" wind="1 -2 .5" gravity=".2 .3 -9.7"', TURNED, BALLS, {}),
        (f"{SHELL} {air(0.3, -0.2)}", 'density="1.1" viscosity=".001"', TURNED, STILL, {}),
        (f"{SHELL} {air(0.3, 0.1)}", 'density="1.2" gravity="0 0 0"', LEVEL, BALLS, {}),
        (CLEAN, 'wind="1 0 0"', LEVEL, BALLS, {}),
        (CLEAN, 'density="1.2"', LEVEL, BALLS, {"size": 'size=".019" mass=".0025"'}),
        (CLEAN, 'density="1.2"', LEVEL, BALLS, {"size": 'size=".022" mass=".03"'}),
        (CLEAN, 'density="1.2"', LEVEL, BALLS, {"body": 'gravcomp=".0149"'}),
        (CLEAN, 'density="1.2"', LEVEL, STILL, {"joint": 'damping=".0001"'}),
    ],
    ids=[
        "density", "turned, wind and tilt", "viscosity", "no gravity", "vacuum", "small and light",
        "large and heavy", "buoyancy", "damping of the joint",
    ],
)  # fmt: skip
def test_a_scene_flies_as_it_says(geom, option, table, balls, more):
    one = scene(geom, option, table, **more)
    expected = Simulator.from_dict(stated_effects(one)).without_surfaces().fly(balls, FLIGHT).states
    assert np.abs(one.fly(balls, FLIGHT) - expected)[..., :3].max() < 5e-6


def test_a_bounce_is_where_and_what_the_scene_says():
    one = scene(f'{CLEAN} margin=".001"', PLAIN, LEVEL, size='size=".022" mass=".0027"')
    drop = np.array([[0.0, 0.5, 0.1, 0.0, 1.0, -3.0, 0.0, 0.0, 0.0]])
    said = stated_effects(one)
    assert said["table_height"]["h"] == pytest.approx(0.003)
    expected = Simulator.from_dict(said).fly(drop, [0.1]).states[0, 0]
    flown = one.fly(drop, np.array([0.1]))[0, 0]
    # The ball is in the table for .8 ms, in which the law does not let it move on.
    np.testing.assert_allclose(flown[:3], expected[:3], atol=0.003)
    np.testing.assert_allclose(flown[3:6], expected[3:6], atol=0.02)


def test_without_fluidshape_the_ball_is_a_cube_whose_drag_is_the_mean_over_its_orientations():
    quaternions = np.random.default_rng(3).normal(size=(400, 4))
    launch, moment = np.array([[0.0, 0.0, 3.0, 0.0, 8.0, 0.0, 0.0, 0.0, 0.0]]), np.array([0.002])
    one = scene(SHELL, 'density="1.2" gravity="0 0 0"')
    cd = stated_effects(one)["drag"]["cd"]
    assert cd == pytest.approx(3.0 / math.pi)
    # Along an axis of the cube, drag is 4/3 of the mean over all directions.
    expected = Simulator.from_dict({"drag": {"cd": cd * 4 / 3}}).fly(launch, FLIGHT).states
    assert np.abs(one.fly(launch, FLIGHT) - expected)[..., :3].max() < 5e-6
    losses = []
    for quaternion in quaternions:
        one.model.qpos0[3:7] = quaternion / np.linalg.norm(quaternion)
        losses.append(8.0 - one.fly(launch, moment)[0, 0, 4])
    expected = 8.0 - Simulator.from_dict({"drag": {"cd": cd}}).fly(launch, moment).states[0, 0, 4]
    assert np.mean(losses) == pytest.approx(expected, rel=0.02)


def test_the_air_slows_spin_as_noted():
    one = scene(f"{SHELL} {air(0.0, 0.0, spin=1.5)}", 'density="1.2"')
    note = next(note for note in scene_notes(one) if "third number of fluidcoef" in note)
    assert "300 rad/s by 4 of it per second" in note
    launch = np.array([[0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 300.0, 0.0, 0.0]])
    spin = one.fly(launch, np.array([0.5]))[0, 0, 6]
    assert spin == pytest.approx(300.0 / (1.0 + 4.02 * 0.5), rel=0.01)  # dw/dt = -k |w| w


@pytest.mark.parametrize(
    ("word", "changed"),
    [
        ("vacuum", {"option": 'timestep=".00005"'}),
        ("vacuum", {"rest": '<option><flag spring="disable" damper="disable"/></option>'}),
        ("wind has no effect", {"option": 'wind="1 0 0" timestep=".00005"'}),
        ("density of the air", {"option": 'density="1.225" timestep=".00005"'}),
        ("no fluidshape", {"geom": f'{SHELL} {FRICTIONLESS} fluidcoef=".235 0 0 0 .57"'}),
        ("first number of fluidcoef", {"geom": f"{SHELL} {FRICTIONLESS} {air(0.94)}"}),
        ("fifth number of fluidcoef", {"geom": f"{SHELL} {FRICTIONLESS} {air(0.47, -0.431)}"}),
        ("third number of fluidcoef", {"geom": f"{SHELL} {FRICTIONLESS} {air(0.47, 0.1, 1.5)}"}),
        ("viscosity slows spin", {"option": f'{PLAIN} viscosity=".001"'}),
        ("no gravity", {"option": f'{PLAIN} gravity="0 0 0"'}),
        ("no gravity", {"rest": '<option><flag gravity="disable"/></option>'}),
        ("shellinertia", {"geom": f"{air(0.47)} {FRICTIONLESS}"}),
        ("integrator=", {"option": 'density="1.2" timestep=".0005" integrator="implicitfast"'}),
        ("time steps", {"option": 'density="1.2" timestep=".0005"'}),
        ("time constant", {"geom": FAST}),
        ("differ in sign", {"geom": f'{CLEAN.replace("-150", "150")} priority="1"'}),
        ("MuJoCo's default", {"geom": f'{SHELL} {air(0.47)} condim="1"'}),
        ("into the table", {"geom": CLEAN.replace("-16000000", "-1000000")}),
        ("of the slip at most", {"geom": GRIPPING}),
        ("pyramid", {"geom": GRIPPING}),
        ("condim", {"geom": f"{GRIPPING}".replace('condim="3"', 'condim="4"')}),
        ("takes restitution", {"rest": pair(f'{OWN} solreffriction="0 -5000"')}),
        ("differs with direction", {"rest": pair(OWN.replace(".2 .2", ".2 .3"))}),
        ("weighs", {"geom": CLEAN, "size": 'size=".02" density="1000"'}),
        ("radius of", {"geom": CLEAN, "size": 'size=".019" mass=".0027"'}),
        ("damping of the free joint", {"joint": 'damping=".0001"'}),
        ("armature", {"joint": 'armature=".0001"'}),
        ("no table", {"table": ""}),
        ("not 2.74", {"table": LEVEL.replace("1.37", "1.35")}),
        ("nothing pushes", {"rest": '<option><flag contact="disable"/></option>'}),
        ("a simulator takes", {"option": f'{PLAIN} gravity="0 0 9.81"', "table": ""}),
    ],
)
def test_what_one_may_not_expect_is_noted_and_nothing_is_logged(
    tmp_path, monkeypatch, word, changed
):
    monkeypatch.chdir(tmp_path)  # where MuJoCo would log
    assert word in notes_of(**changed)
    assert list(tmp_path.iterdir()) == []
