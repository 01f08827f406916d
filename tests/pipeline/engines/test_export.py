"""Simulators as code fly as they do here, in Python and in PyBullet."""

import ast

import numpy as np
import pytest
from hypothesis import example, given, settings
from typer.testing import CliRunner

from rallygap.models.audit.probes import bounce_probes, flight_probes
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import hypotheses
from rallygap.pipeline.cli import app
from rallygap.pipeline.engines.export.code import ENGINES, ball_effects
from rallygap.pipeline.engines.load import module_of_file
from tests.models.audit.test_audit import FLIGHT, PLAIN, TABLE, some_of

# Every effect of flight and of the table, away from its neutral value.
ALL = Simulator.from_dict(PLAIN)
for one in hypotheses(ALL):
    low, high = one.declaration.bounds
    if one.phase != "sensor" and one.effect not in PLAIN:
        ALL = one.at(ALL, 0.1 * high if high <= 1.0 else 0.02 * high)
FIRST = np.array([0.1, 1.0, 0.3, 0.5, -5.0, -1.0, 120.0, 20.0, -60.0])  # of one ball
PROBES = (flight_probes(), bounce_probes())


def imported(path, code):
    path.write_text(code)
    return module_of_file(path)


def largest_distance(module, simulator):
    """m, between flights of the code and of the simulator."""
    return max(
        np.abs(np.array(module.fly(probes.states[::4], probes.times)) - flown)[..., :3].max()
        for probes in PROBES
        for flown in [simulator.fly(probes.states[::4], probes.times).states]
    )


@settings(max_examples=5, deadline=None)
@given(some_of(FLIGHT), some_of(TABLE))
@example(ALL.to_dict(), {})
def test_any_list_is_the_same_in_code(tmp_path_factory, flight, table):
    simulator = Simulator.from_dict({**PLAIN, **flight, **table})
    code = ball_effects(simulator, "some", [], "python")
    module = imported(tmp_path_factory.mktemp("code") / "ball_effects.py", code)
    assert largest_distance(module, simulator) < 1e-6


@pytest.mark.parametrize("engine", ENGINES)
def test_the_code_depends_on_the_standard_library_and_its_engine_alone(engine):
    code = ball_effects(ALL, "all", [], engine)
    named = set()
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            named |= {one.name for one in node.names}
        if isinstance(node, ast.ImportFrom):
            named.add(node.module)
    assert named - {engine} == {"math", "typing"}


def test_a_ball_of_pybullet_flies_as_the_simulator(tmp_path):
    pybullet = pytest.importorskip("pybullet")
    module = imported(tmp_path / "ball_effects.py", ball_effects(ALL, "all", [], "pybullet"))
    yaw, origin, dt = 0.7, (1.0, 2.0, 0.76), 1 / 240
    client = pybullet.connect(pybullet.DIRECT)
    try:
        own = {"physicsClientId": client}
        pybullet.setGravity(0, 0, -9.81, **own)
        sphere = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.02, **own)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, **own)
        ball = pybullet.createMultiBody(0.0027, sphere, **own)
        table = pybullet.createMultiBody(0, plane, basePosition=[0, 0, 0.76], **own)
        flying = module.Ball(ball, table, dt, origin, yaw, client)
        flying.set(tuple(FIRST))
        for _ in range(120):
            flying.step()
        flown = np.array(flying.state())
        place, _ = pybullet.getBasePositionAndOrientation(ball, physicsClientId=client)
    finally:
        pybullet.disconnect(client)
    expected = ALL.fly(FIRST, [120 * dt])
    assert expected.contacts.count[0] == 1
    assert flown == pytest.approx(expected.states[0, 0], abs=1e-4)
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    assert np.array(place[:2]) == pytest.approx(turn @ flown[:2] + origin[:2])


TURNED = """
<mujoco><option timestep="{step}" integrator="{integrator}"/><worldbody>
<geom type="box" size="1.37 .7625 .0125" pos="1 2 .7475"/>
<geom type="box" size=".1 .1 .1" pos="-3 2 1"/>
<body name="ball" quat=".5 .5 .5 .5"><freejoint/>
<geom type="sphere" size=".02" mass=".0027"/></body></worldbody></mujoco>
"""
AXES = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))  # the table's length is along x


def ball_of_mujoco(folder, simulator, step, integrator="RK4"):
    mujoco = pytest.importorskip("mujoco")
    module = imported(folder / "ball_effects.py", ball_effects(simulator, "all", [], "mujoco"))
    model = mujoco.MjModel.from_xml_string(TURNED.format(step=step, integrator=integrator))
    return module.Ball(model, mujoco.MjData(model), "ball", (1.0, 2.0, 0.76), AXES)


@pytest.mark.parametrize(
    ("step", "integrator", "height"),
    [
        (0.002, "Euler", 0.0),
        (0.005, "RK4", 0.0),
        # The scene's own table is not met where the table of the list has another height.
        (0.002, "RK4", -0.03),
        (0.002, "RK4", 0.03),
    ],
)
def test_a_ball_of_mujoco_flies_as_the_simulator(tmp_path, step, integrator, height):
    simulator = ALL.amended("table_height", h=height) if height else ALL
    flying = ball_of_mujoco(tmp_path, simulator, step, integrator)
    flying.set(tuple(FIRST))
    assert flying.state() == pytest.approx(tuple(FIRST))
    for _ in range(round(0.5 / step)):
        flying.step()
    expected = simulator.fly(FIRST, [0.5])
    assert expected.contacts.count[0] == 1
    assert np.array(flying.state()) == pytest.approx(expected.states[0, 0], abs=1e-4)


def test_what_is_not_the_table_meets_the_ball_as_before(tmp_path):
    flying = ball_of_mujoco(tmp_path, ALL, 0.002)
    flying.set((0.0, -3.85, 0.24, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0))  # towards the second box
    for _ in range(50):
        flying.step()
    assert flying.state()[1] > -3.9


def test_the_command_writes_a_file_with_the_origin_of_its_values(tmp_path):
    amended = tmp_path / "amended.yaml"
    amended.write_text("# drag.cd: 0.54 before; estimated 0.47 from lab\ndrag: {cd: 0.47}\n")
    out = tmp_path / "ball_effects.py"
    result = CliRunner().invoke(app, ["export", str(amended), "--to", "python", "--out", str(out)])
    assert result.exit_code == 0, result.output
    assert "drag.cd: 0.54 before; estimated 0.47 from lab" in out.read_text()


def test_another_engine_is_refused():
    result = CliRunner().invoke(app, ["export", "literature", "--to", "unreal"])
    assert "unreal is no engine; give python or pybullet or mujoco" in str(result.exception)


@pytest.mark.parametrize(
    "text",
    [
        '"""\nimport pathlib; pathlib.Path("executed").touch()\n"""',
        r"from C:\Users\lab\x and \N{bad}",
        'ends with ""',
        "\x00 \r \u2028 \udcff",
    ],
)
def test_text_of_a_user_stays_text_in_the_code(tmp_path, monkeypatch, text):
    monkeypatch.chdir(tmp_path)
    code = ball_effects(ALL, text, [text], "python")
    imported(tmp_path / "ball_effects.py", code)
    assert not (tmp_path / "executed").exists()
    assert ast.get_docstring(ast.parse(code), clean=False).count(text) == 2
