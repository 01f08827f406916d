"""Verdict: identities, the file with its schema and reader, and the amended simulator."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from rallygap.models.ball.sensor import measured_positions
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap import verdict as verdict_module
from rallygap.models.gap.amend.simulator import amended, amended_yaml
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.verdict import (
    CameraNodes,
    Cause,
    Gap,
    PhaseShares,
    Unexplained,
    Verdict,
    VerdictError,
    json_schema,
)
from tests.models.gap.hidden import NOMINAL


def cause(identity, estimate, nominal=0.0, possible=("drag.cd",), role="leading"):
    return Cause(
        identity=identity,
        role=role,
        kind="wrong_value" if nominal else "missing_effect",
        unit="1",
        nominal=nominal,
        estimate=estimate,
        interval=(estimate - 0.01, estimate + 0.01),
        p_value=1e-4,
        gap_share=0.5,
        possible=(identity, *possible),
    )


WIND = cause("wind.y", 0.3)
RESTITUTION = cause("table_bounce.restitution", 0.9, nominal=0.92)
VERDICT = Verdict(
    verdict="ambiguous",
    causes=(WIND, RESTITUTION),
    unexplained=Unexplained(share=0.0, p_value=0.4),
    phases=PhaseShares(flight=0.5, table=0.5, sensor=0.0),
    gap=Gap(
        horizons_ms=(100,),
        before_mm=(9.0,),
        after_mm=(5.0,),
        floor_mm=(4.5,),
        removable_closed=0.9,
        removable_closed_interval=(0.8, 1.0),
    ),
    minimum_detectable={"drag.cd": 0.01},
    not_identifiable=("time_offset.tau",),
    limitations=("few shots",),
)


@pytest.mark.parametrize("identity", ["drag.cf", "drag", "wind.x.y", ""])
def test_an_identity_that_is_not_in_the_catalogue_is_refused(identity):
    hint = r"; did you mean drag\.cd\?" if identity == "drag.cf" else ""
    with pytest.raises(ValueError, match=f"no parameter '{identity}'{hint}"):
        Hypothesis.from_identity(identity)


@pytest.mark.parametrize(
    ("identity", "others", "ambiguous"),
    [
        ("wind.x", (), False),
        ("wind.x", ("wind.y",), False),
        ("wind.x", ("wind.y", "drag.cd"), True),
        ("table_bounce.restitution", ("table_bounce.friction",), True),
    ],
)
def test_components_of_one_vector_are_one_quantity(identity, others, ambiguous):
    found = cause(identity, 0.3, possible=others)
    assert (found.ambiguous, found.alternatives) == (ambiguous, others)


def test_a_verdict_survives_its_file_and_has_the_committed_schema(tmp_path):
    path = tmp_path / "verdict.json"
    path.write_text(VERDICT.to_json())
    assert Verdict.load(path) == VERDICT
    path = Path(verdict_module.__file__).with_name("verdict.schema.json")
    assert path.read_text() == json_schema(), "write json_schema() into verdict.schema.json"


def changed(**fields):
    return json.dumps({**json.loads(VERDICT.to_json()), **fields})


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "is not JSON"),
        ("[" * 100_000, "is not JSON"),
        ("[]", "has no version"),
        (changed(version=None), "has no version"),
        (changed(version=1), "has version 1, and version 2 is read"),
        (changed(causes=[{}]), r"causes\.0\.identity: Field required"),
        (changed(effects=[]), "effects: Extra inputs"),
        ("\udcff", "codec can't decode"),
        (None, "cannot be read: No such file"),
    ],
)
def test_a_file_that_is_no_verdict_is_refused(tmp_path, text, problem):
    path = tmp_path / "verdict.json"
    if text is not None:
        path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(VerdictError, match=rf"verdict\.json: .*{problem}"):
        Verdict.load(path)


def test_reading_a_verdict_imports_no_inference():
    code = (
        "import sys; from rallygap.models.gap.verdict import Verdict; "
        "names = ('scipy', 'numba', 'rallygap.models.gap.'); "
        "print([m for m in sys.modules if m.startswith(names)])"
    )
    root = Path(verdict_module.__file__).parents[3]
    shown = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, check=True)
    assert set(json.loads(shown.stdout.decode().replace("'", '"'))) == {
        f"rallygap.models.gap.{name}" for name in ("hypotheses", "location", "types", "verdict")
    }


def test_the_amended_simulator_and_its_file_have_the_estimates_within_their_bounds():
    simulator = amended(NOMINAL, VERDICT)
    assert simulator.effects["wind"] == {"x": 0.0, "y": 0.3, "z": 0.0}
    assert simulator.effects["table_bounce"] == {"restitution": 0.9, "friction": 0.25}
    assert simulator.effects["drag"] == NOMINAL.effects["drag"]
    far = VERDICT.model_copy(update={"causes": (cause("spin_decay.c", -0.1),)})
    assert amended(NOMINAL, far).effects["spin_decay"]["c"] == 0.0
    text = amended_yaml(NOMINAL, VERDICT, "my_data")
    assert Simulator.from_dict(yaml.safe_load(text)) == amended(NOMINAL, VERDICT)
    assert "wind.y: missing before" in text
    assert "table_bounce.restitution: 0.92 before" in text


def test_minor_structure_is_amended_on_request_only():
    minor = cause("spin_decay.c", 0.004, role="minor")
    verdict = VERDICT.model_copy(update={"causes": (*VERDICT.causes, minor)})
    assert (verdict.leading, verdict.main_causes) == (VERDICT.causes, VERDICT.causes)
    assert amended(NOMINAL, verdict) == amended(NOMINAL, VERDICT)
    assert amended(NOMINAL, verdict, minor=True).effects["spin_decay"] == {"c": 0.004}
    assert "spin_decay" in amended_yaml(NOMINAL, verdict, "my_data", minor=True)


def distorted(nodes, amplitude=0.002):
    camera = CameraNodes(length=0.8, nodes=nodes)
    found = cause("camera_distortion.amplitude", amplitude, role="sensor", possible=())
    return VERDICT.model_copy(update={"causes": (found,), "camera": camera})


def test_an_error_of_the_cameras_is_part_of_the_amended_sensor_and_adds_to_one_before():
    places = np.array([[0.1, 0.2, 0.3], [0.0, 1.0, 0.2]])
    verdict = distorted(((0.0, 0.0, 0.2, 1.0, -1.0, 0.0), (0.0, 1.0, 0.2, 0.5, 0.0, 0.5)))
    simulator = amended(NOMINAL, verdict)
    weights = np.array(verdict.camera.nodes)
    shares = np.exp(-((places[:, None] - weights[:, :3]) ** 2).sum(axis=2) / (2 * 0.8**2))
    error = 0.002 * shares @ weights[:, 3:]
    assert measured_positions(simulator, places) == pytest.approx(places + error, abs=1e-12)
    text = amended_yaml(NOMINAL, verdict, "my_data")
    assert Simulator.from_dict(yaml.safe_load(text)) == simulator

    second = distorted(((0.0, 1.0, 0.2, 0.5, 0.0, 0.5),), amplitude=0.003)
    alone, both = (amended(one, second) for one in (NOMINAL, simulator))
    errors = [measured_positions(one, places) - places for one in (alone, both)]
    assert errors[0] + error == pytest.approx(errors[1], abs=1e-12)
