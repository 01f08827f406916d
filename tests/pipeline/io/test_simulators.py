"""Simulators by name or file."""

import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError


def test_a_shipped_simulator_goes_by_its_name():
    assert load_simulator("imperfect_c") == shipped("imperfect_c")


def test_a_file_goes_by_its_path(tmp_path):
    path = tmp_path / "lab.yaml"
    path.write_text("gravity: {g: 9.79}\ndrag: {cd: 0.5}\n")
    effects = load_simulator(str(path)).effects
    assert effects == {"gravity": {"g": 9.79}, "drag": {"cd": 0.5}}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("drag: {cd: 0.5", "is not YAML"),
        ("drag: {cd: fast}", "a number from 0 to 1.5"),
        ("- drag", "a list of effects"),
        ("", "a list of effects"),
    ],
)
def test_a_file_that_describes_no_simulator_is_refused_by_name(tmp_path, text, says):
    path = tmp_path / "lab.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=says) as caught:
        load_simulator(str(path))
    assert "lab.yaml" in str(caught.value)


@pytest.mark.parametrize("name", ["imperfect_d", "no/such/file.yaml"])
def test_a_simulator_that_is_not_there_is_named(name):
    with pytest.raises(InputError, match="there"):
        load_simulator(name)
