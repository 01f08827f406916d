"""Files of scenes: what cannot be used is refused in one line."""

import subprocess
import sys
from pathlib import Path

import pytest

from rallygap.pipeline.engines.load import load_scene
from rallygap.pipeline.runtime.errors import InputError

SPHERE = '<geom type="sphere" size=".02" mass=".0027"/>'
BALL = f'<body name="ball"><freejoint/>{SPHERE}</body>'
SPARE = f'<body name="spare" pos="1 0 0"><freejoint/>{SPHERE}</body>'
LOADS = "import sys, rallygap.pipeline.engines.load; sys.exit('mujoco' in sys.modules)"


@pytest.fixture
def written(tmp_path, monkeypatch):
    """Write a scene; what MuJoCo logs would land next to it."""
    monkeypatch.chdir(tmp_path)

    def write(world):
        Path("scene.xml").write_text(f"<mujoco><worldbody>{world}</worldbody></mujoco>")
        return "scene.xml"

    return write


def test_a_scene_has_the_name_of_its_file(written):
    pytest.importorskip("mujoco")
    assert load_scene(written(BALL)).name == "scene"
    assert load_scene(f"{written(BALL + SPARE)}#spare").ball.name == "spare"


@pytest.mark.parametrize(
    ("world", "problem"),
    [
        ("", "scene.xml: there is no ball, that is a body with a free joint"),
        (BALL + SPARE, "scene.xml: 2 bodies can be the ball: ball, spare; name one of them"),
        ("<body><freejoint/></body>", "scene.xml: MuJoCo cannot read it: Error: mass and inertia"),
        ('<geom type="round"/>', "scene.xml: MuJoCo cannot read it: XML Error: .*keyword: 'round'"),
        ('<geom type="mesh" mesh="none"/>', "scene.xml: MuJoCo cannot read it: .*none"),
        ("<body>", "scene.xml: MuJoCo cannot read it: XML parse error"),
    ],
)
def test_a_file_that_is_no_scene_with_a_ball_is_refused(written, world, problem):
    pytest.importorskip("mujoco")
    with pytest.raises(InputError, match=problem) as caught:
        load_scene(written(world))
    assert "\n" not in str(caught.value)
    assert [path.name for path in Path().iterdir()] == ["scene.xml"]


@pytest.mark.parametrize("content", [b"", b"\x00\xff\xfe", b"ball: {}\n", b"<robot/>"])
def test_other_files_are_refused(written, content):
    pytest.importorskip("mujoco")
    path = written("")
    Path(path).write_bytes(content)
    with pytest.raises(InputError, match=r"scene\.xml: "):
        load_scene(path)


def test_a_file_that_is_not_there_is_refused(tmp_path):
    for path in (tmp_path / "none.xml", tmp_path):
        with pytest.raises(InputError, match="there is no such file"):
            load_scene(str(path))


def test_without_mujoco_one_line_says_what_brings_it(written, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    for name in [name for name in sys.modules if name.startswith("rallygap.models.engines.mujoco")]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(InputError, match=r"scene.xml: pip install -e '.\[mujoco\]' brings MuJoCo"):
        load_scene(written(BALL))


def test_mujoco_is_loaded_only_for_a_scene():
    assert subprocess.run([sys.executable, "-c", LOADS], timeout=60).returncode == 0
