"""Balls that MuJoCo flies, against our simulator with the effects that the scene stands for."""

import math

import mujoco
import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_MASS, BALL_RADIUS
from rallygap.models.engines.engine import EngineError, check_deterministic
from tests.models.engines.mujoco.scenes import CONTACT, SHELL, TABLE, air, scene

FLIGHT = np.linspace(0.0, 0.6, 97)  # most of them between time steps
AIR = 'density="1.2"'
GRAVITY = {"gravity": {"g": 9.81}}
LOW = [-0.5, -1.3, 3.0, -1.0, 4.0, -1.0, -150.0, -150.0, -150.0]
HIGH = [0.5, -0.8, 3.5, 1.0, 12.0, 3.0, 150.0, 150.0, 150.0]
BALLS = np.random.default_rng(1).uniform(LOW, HIGH, (10, 9))
STILL = np.where(np.arange(9) < 6, BALLS, 0.0)  # without spin


def differences(one, effects, balls=BALLS, times=FLIGHT):
    """Largest difference in position (mm), velocity (m/s) and spin (rad/s)."""
    apart = np.abs(one.fly(balls, times) - Simulator.from_dict(effects).fly(balls, times).states)
    position, velocity, spin = (float(apart[..., part : part + 3].max()) for part in (0, 3, 6))
    return 1000.0 * position, velocity, spin


WINDY = {"drag": {"cd": 0.47}, "magnus": {"cm": 0.12}, "wind": {"x": 1, "y": -2, "z": 0.5}}


@pytest.mark.parametrize(
    ("geom", "option", "effects", "step"),
    [
        ("", "", {}, 0.002),
        ("", 'gravity=".2 -.3 -9.8"', {"frame_tilt": {"x": 0.020394, "y": -0.030594}}, 0.002),
        (air(0.47), AIR, {"drag": {"cd": 0.47}}, 0.002),
        (air(0.0, -0.4), AIR, {"magnus": {"cm": -0.4}}, 0.002),
        (air(0.47, 0.12), f'{AIR} wind="1 -2 .5"', WINDY, 0.002),
        (air(0.47, 0.12), f'{AIR} wind="1 -2 .5"', WINDY, 0.0002),
    ],
    ids=["gravity", "tilt", "drag", "inverse lift", "wind", "wind and short steps"],
)
def test_flights_with_runge_kutta_agree(geom, option, effects, step):
    g = math.hypot(0.2, 0.3, 9.8) if "gravity" in option else 9.81
    one = scene(f"{SHELL} {geom}", f'{option} timestep="{step}"')
    position, velocity, spin = differences(one, {"gravity": {"g": g}, **effects})
    assert position < 0.005
    assert velocity < 1e-4
    assert spin < 1e-9


def test_viscosity_is_linear_drag_and_slows_spin_at_twice_that_rate_in_a_shell():
    one = scene(f"{SHELL} {air()}", 'viscosity=".001"')
    k1 = 6 * math.pi * BALL_RADIUS * 0.001 / BALL_MASS
    position, _, _ = differences(one, {**GRAVITY, "linear_drag": {"k1": k1}}, STILL)
    assert position < 0.005
    spins = one.fly(BALLS, np.array([0.6]))[:, 0, 6:]
    np.testing.assert_allclose(spins, math.exp(-2 * k1 * 0.6) * BALLS[:, 6:], rtol=1e-6)


@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast"])
def test_other_integrators_err_in_proportion_to_the_step(integrator):
    effects = {**GRAVITY, "drag": {"cd": 0.47}, "magnus": {"cm": 0.12}}
    one = scene(f"{SHELL} {air(0.47, 0.12)}", AIR).with_integrator(integrator)
    coarse, fine = (differences(one.with_step(h), effects)[0] for h in (0.002, 0.0005))
    assert 3.0 < coarse < 12.0
    assert coarse / fine == pytest.approx(4.0, rel=0.05)


def test_a_turned_table_at_its_height_flies_as_one_in_the_world():
    turned = TABLE.replace('pos="0 0 -.0125"', 'pos="1 2 .7475" euler="0 0 -70"')
    geom = f"{SHELL} {air(0.47, 0.12)} {CONTACT}"
    option = f'{AIR} timestep=".0005"'
    launches = BALLS - 2.6 * np.eye(9)[2]
    flown = scene(geom, option, turned).fly(launches, FLIGHT)
    np.testing.assert_allclose(flown[:, 0], launches, atol=1e-12)
    expected = scene(geom, option).fly(launches, FLIGHT)
    assert (expected[..., 5] > 0.0).any() and (expected[..., 2] < 0.1).any()
    # A contact is as sensitive as its step is large to where in a step it begins.
    np.testing.assert_allclose(flown[:, :12], expected[:, :12], atol=1e-9)
    np.testing.assert_allclose(np.median(np.abs(flown - expected)), 0.0, atol=1e-9)


def test_the_orientation_of_the_ball_at_the_start_does_not_turn_its_spin():
    one = scene(SHELL, body='quat=".1 .2 .3 .4"')
    np.testing.assert_allclose(one.fly(BALLS, FLIGHT)[:, -1, 6:], BALLS[:, 6:], rtol=1e-9)


def test_balls_fly_one_by_one_and_leave_nothing_behind_and_none_have_no_flight():
    one = scene(f"{SHELL} {air(0.47, 0.12)} {CONTACT}", AIR)
    check_deterministic(one, BALLS - 2.6 * np.eye(9)[2], FLIGHT)
    assert one.fly(BALLS, np.empty(0)).shape == (10, 0, 9)
    assert one.fly(np.empty((0, 9)), FLIGHT).shape == (0, 97, 9)


def test_other_bodies_start_as_the_keyframe_says():
    # A plate that floats far above in the reference configuration is in the ball's way.
    table = TABLE + (
        '<body name="plate" pos="0 0 50" gravcomp="1"><joint type="slide" axis="0 0 1"/>'
        '<geom type="box" size="2 2 .01" mass="100"/></body>'
    )
    key = '<keyframe><key qpos="-47.4 0 0 .5 1 0 0 0"/></keyframe>'
    ball_above = np.array([[0.0, 0.0, 3.0, *[0.0] * 6]])
    free = scene(SHELL, table=table).fly(ball_above, np.array([0.4]))[0, 0, 2]
    met = scene(SHELL, table=table, rest=key).fly(ball_above, np.array([0.4]))[0, 0, 2]
    assert free == pytest.approx(3.0 - 0.5 * 9.81 * 0.16)
    assert met > free + 0.1


def test_times_between_steps_are_on_the_path():
    one = scene(f"{SHELL} {air(0.47, 0.12)}", f'{AIR} timestep=".004"')
    between = one.fly(BALLS, np.arange(0.0005, 0.6, 0.004))
    exact = one.with_step(0.0005).fly(BALLS, np.arange(0.0005, 0.6, 0.004))
    assert np.abs(between - exact)[..., :3].max() < 1e-7
    assert np.abs(between - exact)[..., 3:6].max() < 5e-4


def test_no_step_overshoots_a_bounce():
    drop = np.array([[0.0, 0.5, 0.1, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0]])
    one = scene(f"{SHELL} {CONTACT}", 'gravity="0 0 0" timestep=".001"')
    steps = one.fly(drop, 0.001 * np.arange(61))[0, :, 2]
    between = one.fly(drop, 0.0001 * np.arange(601))[0, :, 2]
    assert between.min() == pytest.approx(steps.min(), abs=1e-12)


def test_variants_do_not_change_the_scene_and_bad_ones_are_refused():
    one = scene(SHELL)
    assert one.with_step(0.0005).model.opt.timestep == 0.0005
    assert one.with_integrator("Euler").model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER
    assert one.model.opt.timestep == 0.001
    assert one.model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    for step in (0.0, -0.001, math.nan):
        with pytest.raises(EngineError, match="give one above 0"):
            one.with_step(step)
    with pytest.raises(EngineError, match="no integrator called 'euler'; did you mean Euler"):
        one.with_integrator("euler")


def test_a_simulation_that_diverges_or_begins_without_numbers_names_the_ball(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fast = BALLS[:3].copy()
    fast[1, 3] = 1e9
    mixed = 'solref="-1000 5" priority="1"'  # MuJoCo also warns of it
    one = scene(f"{SHELL} {air(0.47)} {mixed}", f'{AIR} timestep=".002"')
    with pytest.raises(EngineError, match=r"scene: ball 1: .* unstable. Time = 0\.00"):
        one.fly(fast, FLIGHT)
    fast[1, 3] = math.nan
    with pytest.raises(EngineError, match="scene: ball 1: "):
        one.fly(fast, FLIGHT)
    assert list(tmp_path.iterdir()) == []  # no log of MuJoCo's
    assert mujoco.get_mju_user_warning() is None
