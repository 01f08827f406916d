"""The simulator as a value: what it accepts, and what it says when it does not."""

import itertools
import re
import subprocess
import sys

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator, SimulatorError
from rallygap.models.ball.simulators import shipped, shipped_names
from tests.models.ball.balls import NOMINAL

BALL = [0.1, 1.2, 0.3, 0.4, -9.0, 0.5, -150.0, 40.0, 30.0]
TIMES = np.arange(1, 61) * 0.005


@pytest.mark.parametrize(
    ("name", "cd", "restitution"),
    [
        ("ground_truth", 0.55, 0.98),
        ("imperfect_a", 0.55, 0.90),
        ("imperfect_b", 0.40, 0.98),
        ("imperfect_c", 0.40, 0.90),
        ("literature", 0.54, 0.93),
    ],
)
def test_the_shipped_simulators_have_the_published_values(name, cd, restitution):
    effects = shipped(name).effects
    assert effects["drag"]["cd"] == cd
    assert effects["table_bounce"]["restitution"] == restitution


def test_an_unknown_simulator_is_named_with_those_that_exist():
    assert len(shipped_names()) == 6
    with pytest.raises(SimulatorError, match="imperfect_c"):
        shipped("imperfect_d")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("dragg: {cd: 0.4}", "there is no effect called 'dragg'; did you mean drag?"),
        ("drag: {c_d: 0.4}", "did you mean cd?"),
        ("drag: {cd: much}", "drag.cd is 'much'; give a number from 0 to 1.5 (1)"),
        ("drag: {cd: .nan}", "a number from 0 to 1.5"),
        ("drag: {cd: true}", "a number from 0 to 1.5"),
        ("drag: {cd: 2}", "drag.cd is 2; give a number from 0 to 1.5 (1)"),
        ("drag: 0.4", "by name"),
        ("table_bounce: {friction: 0.2}", "restitution is missing"),
        ("camera_distortion: {nodes: [[1, 2]]}", "give rows of 6 finite numbers"),
        ("camera_distortion: {nodes: [[1, 2, 3, 4, 5, .inf]]}", "give rows of 6 finite numbers"),
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


def test_the_order_of_the_list_changes_nothing():
    effects = NOMINAL.amended("lift_saturation", kappa=4.0).to_dict()
    flown = [
        Simulator.from_dict(dict(order)).fly(BALL, TIMES).states
        for order in itertools.islice(itertools.permutations(effects.items()), 0, 120, 30)
    ]
    for states in flown[1:]:
        np.testing.assert_array_equal(states, flown[0])


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
