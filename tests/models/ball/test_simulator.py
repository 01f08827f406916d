"""The simulator as a value: what it accepts, and what it says when it does not."""

import re
import subprocess
import sys

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator, SimulatorError
from rallygap.models.ball.simulators import shipped
from tests.models.ball.balls import NOMINAL

PUBLISHED = {
    "ground_truth": (0.55, 0.98),
    "imperfect_a": (0.55, 0.90),
    "imperfect_b": (0.40, 0.98),
    "imperfect_c": (0.40, 0.90),
    "literature": (0.54, 0.93),
}


@pytest.mark.parametrize(("name", "published"), PUBLISHED.items())
def test_the_shipped_simulators_have_the_published_values(name, published):
    effects = shipped(name).effects
    assert (effects["drag"]["cd"], effects["table_bounce"]["restitution"]) == published


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("dragg: {cd: 0.4}", "there is no effect called 'dragg'; did you mean drag?"),
        ("drag: {c_d: 0.4}", "did you mean cd?"),
        ("drag: {cd: much}", "drag.cd is 'much'; give a number from 0 to 1.5 (1)"),
        ("drag: {cd: .nan}", "a number from 0 to 1.5"),
        (f"drag: {{cd: {10**400}}}", "a number from 0 to 1.5"),
        ("drag: {cd: true}", "a number from 0 to 1.5"),
        ("drag: {cd: 2}", "drag.cd is 2; give a number from 0 to 1.5 (1)"),
        ("drag: 0.4", "by name"),
        ("table_bounce: {friction: 0.2}", "restitution is missing"),
        ("camera_distortion: {nodes: [[1, 2]]}", "give rows of 6 finite numbers"),
        ("camera_distortion: {nodes: [[1, 2, 3, 4, 5, .inf]]}", "give rows of 6 finite numbers"),
        (f"camera_distortion: {{nodes: [[1, 2, 3, 4, 5, {10**400}]]}}", "rows of 6 finite"),
        ("[1, 2]", "a list of effects"),
        ("drag: {cd: 0.4", "is not YAML"),
        (None, "there is no such file"),
    ],
)
def test_a_file_that_is_no_simulator_is_named_with_what_is_wrong(tmp_path, text, says):
    path = tmp_path / "simulator.yaml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(SimulatorError, match=re.escape(says)) as caught:
        Simulator.load(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_left_out_parameters_are_neutral():
    assert NOMINAL.amended("wind", y=0.5).effects["wind"] == {"x": 0.0, "y": 0.5, "z": 0.0}


@given(st.sampled_from(list(catalogue())), st.data())
@settings(max_examples=40)
def test_a_simulator_survives_yaml(name, data):
    values = {p.name: data.draw(st.floats(*p.bounds)) for p in catalogue()[name].parameters}
    simulator = NOMINAL.amended(name, **values)
    assert Simulator.from_dict(yaml.safe_load(yaml.safe_dump(simulator.to_dict()))) == simulator


PLUGIN = """
from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Air

effect = Effect("updraft", "the air rises", "a += (0, 0, a)", "flight",
    (Parameter("a", unit="m/s^2", bounds=(-5.0, 5.0), observed="never"),))

@effect.adds("specific_force")
def specific_force(air: Air, a: float) -> tuple[float, float, float]:
    return (0.0, 0.0, a)
"""


def test_another_package_can_offer_an_effect(tmp_path):
    (tmp_path / "updraft.py").write_text(PLUGIN)
    info = tmp_path / "updraft-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: updraft\nVersion: 1\n")
    (info / "entry_points.txt").write_text("[rallygap.effects]\nupdraft = updraft\n")
    program = (
        "from rallygap.models.ball.simulator import Simulator\n"
        "sim = Simulator.from_dict({'updraft': {'a': 2.0}})\n"
        "print(sim.fly([0.0] * 9, [1.0]).states[0, 0, 2])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={"PYTHONPATH": str(tmp_path), "HOME": str(tmp_path), "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert float(done.stdout) == pytest.approx(1.0)
