"""Simulators by name or file, and amended ones by what they serve."""

import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.io.amended_simulators import amended_by, case_name, read_amended
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.amendments import write_amended


def test_a_shipped_simulator_goes_by_its_name_and_a_file_by_its_path(tmp_path):
    assert load_simulator("imperfect_c") == shipped("imperfect_c")
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


def test_amended_simulators_of_the_first_split_serve_others(tmp_path):
    for split in range(2):
        for source in ("lab", "arena"):
            write_amended(tmp_path, source, "imperfect_c", {"drag": {"cd": 0.5 + split}}, split)
    found = [
        (one.source, one.base, one.simulator.effects["drag"]) for one in read_amended(tmp_path)
    ]
    assert found == [(name, "imperfect_c", {"cd": 0.5}) for name in ("arena", "lab")]


def test_a_simulator_is_found_by_its_source_and_what_it_was(tmp_path):
    write_amended(tmp_path, "lab", "imperfect_c", {"wind": {"x": 0.5}})
    found = amended_by(tmp_path, "lab", "imperfect_c")
    assert found == shipped("imperfect_c").amended("wind", x=0.5)
    assert amended_by(tmp_path, "lab", "literature") is None
    assert amended_by(tmp_path / "nowhere", "lab", "imperfect_c") is None


def test_a_broken_one_is_named(tmp_path):
    write_text(tmp_path / f"{case_name('lab', 'mine', 0)}.yaml", "drug: {cd: 0.5}\n")
    with pytest.raises(InputError, match=r"lab-mine-0\.yaml.*did you mean drag"):
        list(read_amended(tmp_path))
