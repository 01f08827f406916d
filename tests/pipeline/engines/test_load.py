"""Engines by what users give; what cannot be used is refused in one line."""

import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.engines.load import load_engine, load_scene
from rallygap.pipeline.runtime.errors import InputError

STATES, TIMES = np.array([[0.0, 0.0, 1.0, 1.0, -5.0, 0.0, 0.0, 0.0, 0.0]]), np.array([0.1, 0.2])
CODE = """
from helper import scale

def fly(states, times):
    flown = states[:, None].repeat(len(times), axis=1)
    flown[..., :3] += scale * times[:, None] * states[:, None, 3:6]
    return flown
"""
SPHERE = '<geom type="sphere" size=".02" mass=".0027"/>'
BALL = f'<body name="ball"><freejoint/>{SPHERE}</body>'
SPARE = f'<body name="spare" pos="1 0 0"><freejoint/>{SPHERE}</body>'
needs_mujoco = pytest.mark.skipif(find_spec("mujoco") is None, reason="MuJoCo is not installed")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def code(folder):
    (folder / "mine.py").write_text(CODE)
    (folder / "helper.py").write_text("scale = 1.0\n")
    (folder / "broken.py").write_text("1 / 0\n")


def scene_of(world):
    Path("scene.xml").write_text(f"<mujoco><worldbody>{world}</worldbody></mujoco>")
    return "scene.xml"


def test_a_shipped_simulator_and_a_list_of_effects(folder):
    (folder / "list.yaml").write_text("gravity: {g: 9.81}\n")
    assert load_engine("list.yaml").fly(STATES, TIMES).shape == (1, 2, 9)
    expected = shipped("literature").fly(STATES, TIMES).states
    np.testing.assert_array_equal(load_engine("literature").fly(STATES, TIMES), expected)


@pytest.mark.parametrize("name", ["mine.py:fly", "mine:fly"])
def test_a_function_of_a_file_or_of_a_module(code, name):
    assert load_engine(name).fly(STATES, TIMES)[0, :, 1] == pytest.approx([-0.5, -1.0])


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("other.py:fly", "there is no such file"),
        ("mine.py:fli", "no function 'fli'; did you mean fly"),
        ("broken.py:fly", "cannot be imported: ZeroDivisionError"),
        ("nowhere.at_all:fly", "cannot be imported: ModuleNotFoundError"),
        ("litrature", "did you mean literature"),
        pytest.param("none.xml", "there is no such file", marks=needs_mujoco),
    ],
)
def test_what_cannot_be_had_is_one_sentence(code, name, problem):
    with pytest.raises(InputError, match=problem):
        load_engine(name)


@needs_mujoco
def test_a_scene_has_the_name_of_its_file(folder):
    assert load_scene(scene_of(BALL)).name == "scene"
    assert load_scene(f"{scene_of(BALL + SPARE)}#spare").ball.name == "spare"


@needs_mujoco
@pytest.mark.parametrize(
    ("world", "problem"),
    [
        (BALL + SPARE, "2 bodies can be the ball: ball, spare; name one of them"),
        ('<geom type="round"/>', "MuJoCo cannot read it: XML Error: .*keyword: 'round'"),
        ("<body>", "MuJoCo cannot read it: XML parse error"),
        ("\0", "MuJoCo cannot read it: "),
    ],
)
def test_a_file_that_is_no_scene_with_a_ball_is_refused(folder, world, problem):
    with pytest.raises(InputError, match=f"scene.xml: {problem}") as caught:
        load_scene(scene_of(world))
    assert "\n" not in str(caught.value)
    assert [path.name for path in folder.iterdir()] == ["scene.xml"]  # MuJoCo logs nothing


def test_without_mujoco_one_line_says_what_brings_it(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    for name in [name for name in sys.modules if name.startswith("rallygap.models.engines.mujoco")]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(InputError, match=r"scene.xml: pip install -e '.\[mujoco\]' brings MuJoCo"):
        load_scene(scene_of(BALL))
