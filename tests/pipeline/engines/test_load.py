"""Engines by what users give."""

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.engines.load import load_engine
from rallygap.pipeline.runtime.errors import InputError

STATES, TIMES = np.array([[0.0, 0.0, 1.0, 1.0, -5.0, 0.0, 0.0, 0.0, 0.0]]), np.array([0.1, 0.2])
CODE = """
from helper import scale

def fly(states, times):
    flown = states[:, None].repeat(len(times), axis=1)
    flown[..., :3] += scale * times[:, None] * states[:, None, 3:6]
    return flown
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(CODE)
    (tmp_path / "helper.py").write_text("scale = 1.0\n")
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    monkeypatch.undo()


def test_a_shipped_simulator_and_a_list_of_effects(folder):
    (folder / "list.yaml").write_text("gravity: {g: 9.81}\n")
    for name in ("literature", "list.yaml"):
        assert load_engine(name).fly(STATES, TIMES).shape == (1, 2, 9)
    expected = shipped("literature").fly(STATES, TIMES).states
    np.testing.assert_array_equal(load_engine("literature").fly(STATES, TIMES), expected)


@pytest.mark.parametrize("name", ["mine.py:fly", "mine:fly"])
def test_a_function_of_a_file_or_of_a_module(folder, name):
    assert load_engine(name).fly(STATES, TIMES)[0, :, 1] == pytest.approx([-0.5, -1.0])


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("other.py:fly", "there is no such file"),
        ("mine.py:fli", "no function 'fli'; did you mean fly"),
        ("mine.py:scale", "no function 'scale'"),
        ("broken.py:fly", "cannot be imported: ZeroDivisionError"),
        ("nowhere.at_all:fly", "cannot be imported: ModuleNotFoundError"),
        ("litrature", "did you mean literature"),
    ],
)
def test_what_cannot_be_had_is_one_sentence(folder, name, problem):
    (folder / "broken.py").write_text("1 / 0\n")
    with pytest.raises(InputError, match=problem):
        load_engine(name)
