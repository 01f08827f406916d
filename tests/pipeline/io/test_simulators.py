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
    with pytest.raises(InputError, match=f"{name}.*there"):
        load_simulator(name)


def test_amended_simulators_of_the_first_split_serve_others_by_source_and_what_they_were(tmp_path):
    for split in range(2):
        for source in ("lab", "arena"):
            write_amended(tmp_path, source, "imperfect_c", {"drag": {"cd": 0.5 + split}}, split)
    amended = shipped("imperfect_c").amended("drag", cd=0.5)
    expected = [(source, "imperfect_c", amended) for source in ("arena", "lab")]
    assert list(read_amended(tmp_path)) == expected
    assert amended_by(tmp_path, "lab", "imperfect_c") == amended
    assert amended_by(tmp_path, "lab", "literature") is None
    write_text(tmp_path / f"{case_name('lab', 'mine', 0)}.yaml", "drug: {cd: 0.5}\n")
    with pytest.raises(InputError, match=r"lab-mine-0\.yaml.*did you mean drag"):
        list(read_amended(tmp_path))
