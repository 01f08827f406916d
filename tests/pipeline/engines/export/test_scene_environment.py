"""The amended ball in environments of Gymnasium, as the examples of the documentation have it."""

import sys
from types import ModuleType

import gymnasium
import mujoco
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.engines.export.command import export
from rallygap.pipeline.engines.load import module_of_file
from rallygap.pipeline.runtime.paths import repository_root

LITERATURE = shipped("literature")
STILL = np.zeros(2, dtype=np.float32)
SHOT = (0.1, 1.3, 0.3, 0.2, -5.5, 1.2, -75.0, 20.0, 0.0)


@pytest.fixture(scope="module")
def examples():
    """The wrapper, and the task, which imports the wrapper."""
    folder = repository_root() / "docs/examples"
    task = module_of_file(folder / "mujoco_interception.py")
    return sys.modules["gymnasium_ball"], task


@pytest.fixture(scope="module")
def code(tmp_path_factory):
    """ball_effects.py, of the literature."""
    path = tmp_path_factory.mktemp("code") / "ball_effects.py"
    export("literature", "mujoco", path)
    return path


@pytest.fixture(scope="module")
def ball(code):
    return module_of_file(code).Ball


@pytest.fixture(scope="module")
def wrapper(examples):
    return examples[0].AmendedBall


@pytest.fixture(scope="module")
def task(examples):
    return examples[1]


@pytest.fixture
def amended(wrapper, task, ball):
    return wrapper(task.Interception(), ball)


def of_gymnasium(task, monkeypatch):
    """The same scene in an environment of Gymnasium's own class."""
    # It needs imageio, but only for pictures.
    monkeypatch.setitem(sys.modules, "imageio", ModuleType("imageio"))
    from gymnasium.envs.mujoco import MujocoEnv

    class Rally(MujocoEnv):
        def __init__(self):
            super().__init__(str(task.SCENE), 40, task.Interception().observation_space)

        def reset_model(self):
            return self.data.sensordata.copy()

        def step(self, action):
            self.do_simulation(action, self.frame_skip)
            return self.data.sensordata.copy(), 0.0, False, False, {}

    return Rally()


def flown(env, ball, controls):
    """(controls, 9) states of a shot after each control step, and (controls,) their times, s."""
    env.reset(seed=1)
    scene = env.unwrapped
    ball(scene.model, scene.data).set(SHOT)
    states, times = [], []
    for _ in range(controls):
        env.step(STILL)
        states.append(ball(scene.model, scene.data).state())
        times.append(scene.data.time)
    return np.array(states), np.array(times)


@pytest.mark.parametrize("base", ["own", "gymnasium"])
def test_the_ball_flies_as_the_simulator_and_again_after_a_reset(
    wrapper, task, ball, base, monkeypatch
):
    plain = task.Interception() if base == "own" else of_gymnasium(task, monkeypatch)
    env = wrapper(plain, ball)
    for _ in range(2):
        states, times = flown(env, ball, 8)
        expected = LITERATURE.fly(np.array(SHOT), times)
        assert expected.contacts.count[0] == 1
        assert states == pytest.approx(expected.states[0], abs=1e-4)


def test_observation_and_error_are_those_of_the_amended_ball(amended, task):
    plain = task.Interception()
    ends = []
    for env in (amended, plain):
        first, info = env.reset(seed=3)
        assert np.array_equal(first, plain.reset(seed=3)[0])
        while "error" not in info:
            _, reward, over, _, info = env.step(STILL)
            assert over == ("error" in info) and reward == -info.get("error", 0.0) / task.FAR
        ends.append((env.unwrapped.data.time, info["error"]))
    (amended_end, amended_error), (plain_end, plain_error) = ends
    assert amended_end > plain_end + 0.1  # air slows the ball
    assert abs(amended_error - plain_error) > 0.01


def test_a_scene_that_is_loaded_anew_has_the_amended_ball(wrapper, task, ball):
    class Fresh(task.Interception):
        def reset(self, **options):
            super().__init__()
            return super().reset(**options)

    env = wrapper(Fresh(), ball)
    states, times = flown(env, ball, 3)
    assert states == pytest.approx(LITERATURE.fly(np.array(SHOT), times).states[0], abs=1e-4)


def test_controls_move_the_rest_of_the_scene_as_before(amended, task):
    plain = task.Interception()
    for env in (amended, plain):
        env.reset(seed=0)
        env.step(np.array([0.3, 0.5], dtype=np.float32))
    paddles = [env.unwrapped.data.qpos[-2:] for env in (amended, plain)]
    assert paddles[0] == pytest.approx(paddles[1], abs=1e-9)
    assert paddles[0][0] > 0.01


def test_environments_follow_gymnasium(amended, task):
    check_env(task.Interception(), skip_render_check=True)
    check_env(amended, skip_render_check=True)


class NoSimulation(gymnasium.Env):
    model = mujoco.MjModel.from_xml_string("<mujoco/>")


def test_what_cannot_be_wrapped_is_refused(wrapper, task, ball):
    with pytest.raises(TypeError, match="CartPoleEnv has no scene of MuJoCo in `model` and `data`"):
        wrapper(gymnasium.make("CartPole-v1"), ball)
    with pytest.raises(TypeError, match=r"NoSimulation has no `do_simulation\(ctrl, n_frames\)`"):
        wrapper(NoSimulation(), ball)
    with pytest.raises(KeyError, match="bal"):
        wrapper(task.Interception(), ball, body="bal")


def test_the_example_trains_and_prints_hits_and_errors(task, code, monkeypatch, capsys):
    monkeypatch.setattr(task, "TESTED", 3)
    task.main(str(code), steps=104)
    head, *rows = capsys.readouterr().out.splitlines()
    assert head.split()[:2] == ["trained", "with"]
    assert len(rows) == 3 and all(row.endswith(" mm") and "%" in row for row in rows)
