"""What a verdict on a scene of MuJoCo gives back with the verdict."""

from dataclasses import replace

import pytest

pytest.importorskip("mujoco")

from rallygap.pipeline.engines.load import load_scene
from rallygap.pipeline.gap.diagnose_folder import diagnose_folder, handed_over, write_findings
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.engines.export.scenes import SCENE, does, file_of
from tests.pipeline.verdicts import findings

ORIGIN = "wind.x: missing before; estimated 0.61 m/s from lab (95 % 0.59 to 0.63); verdict named"


def test_a_scene_and_code_are_given_back_with_their_verification(tmp_path):
    source = file_of(tmp_path, SCENE)
    found = replace(findings(simulator_name=str(source.path)), simulator=does(source))
    handed = handed_over(found)
    assert ORIGIN in handed.text and ORIGIN in handed.code
    assert handed.sentences[0] == "Changed attributes of lab.xml: wind."
    found = replace(found, handed=handed)
    assert found.details[-len(handed.sentences) :] == list(handed.sentences)
    out = tmp_path / "out"
    write_findings(found, out)
    assert load_scene(str(out / "scene.xml")).model.opt.wind == pytest.approx((0, -0.61, 0))
    assert "200 shots differ from the list by at most" in (out / "report.html").read_text()
    write_findings(replace(found, simulator_name="sim.yaml", handed=None), out)
    assert not (out / "scene.xml").exists() and not (out / "ball_effects.py").exists()


def test_a_scene_of_the_user_is_not_replaced(tmp_path):
    source = file_of(tmp_path, SCENE)
    (tmp_path / "scene.xml").write_text(SCENE)
    with pytest.raises(InputError, match=r"has a scene\.xml of yours"):
        diagnose_folder(tmp_path, "csv", str(source.path), 0.003, tmp_path)
