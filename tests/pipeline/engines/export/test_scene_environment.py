"""The amended ball in environments of Gymnasium, as the examples of the documentation have it."""

import sys
from types import ModuleType, SimpleNamespace

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
def example(tmp_path_factory):
    """The wrapper, the task, which imports the wrapper, and the ball of the literature's code."""
    task = module_of_file(repository_root() / "docs/examples/mujoco_interception.py")
    code = tmp_path_factory.mktemp("code") / "ball_effects.py"
    export("literature", "mujoco", code)
    wrapper, ball = sys.modules["gymnasium_ball"].AmendedBall, module_of_file(code).Ball
    return SimpleNamespace(task=task, code=code, wrapper=wrapper, ball=ball)


@pytest.fixture
def amended(example):
    return example.wrapper(example.task.Interception(), example.ball)


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
def test_the_ball_flies_as_the_simulator_and_again_after_a_reset(example, base, monkeypatch):
    class Fresh(example.task.Interception):
        """It loads its scene again."""

        def reset(self, **options):
            super().__init__()
            return super().reset(**options)

    plain = Fresh() if base == "own" else of_gymnasium(example.task, monkeypatch)
    env = example.wrapper(plain, example.ball)
    for _ in range(2):
        states, times = flown(env, example.ball, 8)
        expected = LITERATURE.fly(np.array(SHOT), times)
        assert expected.contacts.count[0] == 1
        assert states == pytest.approx(expected.states[0], abs=1e-4)


def test_the_error_is_that_of_the_amended_ball_and_all_else_moves_as_before(amended, example):
    ends = []
    for env in (amended, example.task.Interception()):
        env.reset(seed=3)
        env.step(np.array([0.3, 0.5], dtype=np.float32))
        paddle, info = env.unwrapped.data.qpos[-2:].copy(), {}
        while "error" not in info:
            _, reward, over, _, info = env.step(STILL)
        assert over and reward == -info["error"] / example.task.FAR
        ends.append((paddle, env.unwrapped.data.time, info["error"]))
    (one, late, error), (other, early, plain_error) = ends
    assert one == pytest.approx(other, abs=1e-9) and one[0] > 0.01
    assert late > early + 0.1  # air slows the ball
    assert abs(error - plain_error) > 0.01


def test_environments_follow_gymnasium(amended, example):
    check_env(example.task.Interception(), skip_render_check=True)
    check_env(amended, skip_render_check=True)


def test_what_cannot_be_wrapped_is_refused(example):
    wrapper, ball, loaded = example.wrapper, example.ball, gymnasium.make("CartPole-v1").unwrapped
    loaded.model = mujoco.MjModel.from_xml_string("<mujoco/>")
    with pytest.raises(TypeError, match="CartPoleEnv has no scene of MuJoCo in `model` and `data`"):
        wrapper(gymnasium.make("CartPole-v1"), ball)
    with pytest.raises(TypeError, match=r"CartPoleEnv has no `do_simulation\(ctrl, n_frames\)`"):
        wrapper(loaded, ball)
    with pytest.raises(KeyError, match="bal"):
        wrapper(example.task.Interception(), ball, body="bal")


def test_the_example_trains_and_prints_hits_and_errors(example, monkeypatch, capsys):
    monkeypatch.setattr(example.task, "TESTED", 3)
    example.task.main(str(example.code), steps=104)
    head, *rows = capsys.readouterr().out.splitlines()
    assert head.split()[:2] == ["trained", "with"]
    assert len(rows) == 3 and all(row.endswith(" mm") and "%" in row for row in rows)
