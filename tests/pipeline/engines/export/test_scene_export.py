"""Amended scenes come with what the verification shows; all files are written, or none."""

from dataclasses import replace

import pytest
from typer.testing import CliRunner

from rallygap.models.engines.mujoco.stated import stated_effects
from rallygap.pipeline.cli import app
from rallygap.pipeline.engines.export.code import ball_effects
from rallygap.pipeline.engines.export.command import check_place, export_scene, former_scene
from rallygap.pipeline.engines.export.scene.amended_scene import amended_scene, unsupported
from rallygap.pipeline.engines.export.scene.verification import VerificationShots, scene_sentences
from rallygap.pipeline.engines.load import load_scene
from rallygap.pipeline.gap.diagnose_folder import diagnose_folder, handed_over, write_findings
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.engines.export.scenes import SCENE, amended, changed, does, file_of
from tests.pipeline.verdicts import findings

LIST = """gravity: {g: 9.81}
# drag.cd: 0.3 before; estimated 0.47 from lab (95 % 0.46 to 0.48); verdict named
drag: {cd: 0.47}
magnus: {cm: 0.05}
table_bounce: {restitution: 0.93, friction: 0.0}
"""


def few(simulator):
    """Eight of the shots, for scenes."""
    shots = VerificationShots.of(simulator)
    return VerificationShots(shots.flights[::25], shots.bounces[::25])


def not_stated(found, before):
    """What the export says that no attribute states."""
    return list(unsupported(found.scene, before, found.after, VerificationShots.of(found.after)))


def test_the_command_writes_a_verified_scene_and_code(tmp_path):
    source = file_of(tmp_path, SCENE.replace('"0.001"', '"0.002"'))
    (tmp_path / "amended.yaml").write_text(LIST)
    out = tmp_path / "out"
    words = ["export", str(tmp_path / "amended.yaml"), "--to", "mujoco"]
    words += ["--scene", str(source.path), "--out", str(out)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in out.iterdir()) == ["ball_effects.py", "scene.xml"]
    scene, text = load_scene(str(out / "scene.xml")), (out / "scene.xml").read_text()
    assert stated_effects(scene)["drag"]["cd"] == pytest.approx(0.47)
    assert "estimated 0.47 from lab (95 % 0.46 to 0.48)" in text
    said = result.output.splitlines()
    assert said[0] == "Changed attributes of lab.xml: fluidcoef, solref."
    assert all(f"rallygap: {line}" in text for line in said[:4])
    assert "scene.xml, RK4 at 2 ms: 200 shots differ from the list by at most 0.0" in result.output
    assert "ball_effects.py: 40 shots differ from the list by at most 0.001 mm" in result.output
    assert "belongs into the folder" not in result.output
    assert former_scene(out) == ["scene.xml"]


@pytest.mark.parametrize(
    ("engine", "scene", "problem"),
    [
        ("python", "lab.xml", "is for --to mujoco, not python"),
        ("mujoco", "lab.yaml", "lab.yaml is no scene of MuJoCo; give scene.xml"),
        ("mujoco", "none.xml", "there is no such file"),
    ],
)
def test_other_engines_and_files_are_refused(tmp_path, monkeypatch, engine, scene, problem):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=problem):
        export_scene("literature", engine, scene, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_scene_of_the_user_is_never_replaced(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text(SCENE)
    assert former_scene(tmp_path) == []
    for scene in (str(path), str(tmp_path / "other.xml")):
        with pytest.raises(InputError, match=r"has a scene\.xml of yours"):
            check_place(scene, tmp_path)
    with pytest.raises(InputError, match=r"has a scene\.xml of yours"):
        diagnose_folder(tmp_path, "csv", str(path), 0.003, tmp_path)
    path.write_text("<!-- rallygap: amended -->" + SCENE)
    check_place(str(tmp_path / "other.xml"), tmp_path)
    with pytest.raises(InputError, match="of yours"):
        check_place(f"{path}#ball", tmp_path)


def test_euler_does_not_meet_the_limit_and_the_step_that_does_is_given(tmp_path):
    text = SCENE.replace('integrator="RK4"', "").replace('"0.001"', '"0.004"')
    found = amended(tmp_path, text, {"drag": {"cd": 0.47}})
    said = list(scene_sentences(found.scene, found.after, few(found.after), "scene.xml"))
    assert said[0].startswith("scene.xml, Euler at 4 ms: 8 shots differ") and " over " in said[0]
    assert said[-2].startswith("With RK4 at 4 ms, scene.xml flies within 0.0")
    assert "a contact lasts" in said[-1]


def test_what_no_attribute_says_is_said_with_its_cost(tmp_path):
    changes = {
        "spin_decay": {"c": 0.02},
        "table_height": {"h": 0.002},
        "linear_drag": {"k1": 0.05},
        "time_offset": {"tau": 0.01},
    }
    found = amended(tmp_path, SCENE, changes)
    spin, height, viscosity = not_stated(found, does(file_of(tmp_path, SCENE)))
    assert "says spin_decay.c 0.02 1/m; without it the ball is up to" in spin
    assert "says table_height.h 0.002 m (move" in height
    assert viscosity.startswith("Viscosity, which says linear_drag.k1, also slows spin, by 0.1 of")


def test_a_ball_whose_inertia_is_written_stays_solid_and_that_is_said(tmp_path):
    inertia = '<inertial pos="0 0 0" mass=".0027" diaginertia="4.3e-7 4.3e-7 4.3e-7"/>'
    text = SCENE.replace('shellinertia="true"', "")
    found = amended(tmp_path, text.replace("<freejoint/>", f"<freejoint/>{inertia}"), {})
    assert not_stated(found, found.after)[0].startswith("The ball is no shell")


def test_a_scene_that_cannot_be_amended_leaves_verified_code(tmp_path):
    flags = '<option><flag spring="disable" damper="disable"/></option><worldbody>'
    file = file_of(tmp_path, SCENE.replace("<worldbody>", flags))
    after = changed(file, {"drag": {"cd": 0.47}})
    code = ball_effects(after, "list", [], "mujoco")
    found = amended_scene(str(file.path), does(file), after, code, [])
    assert found.text is None and "passive forces" in str(found.problem)
    assert found.sentences[0] == f"There is no amended scene.xml: {found.problem}."
    assert found.sentences[1].startswith("ball_effects.py: 40 shots differ")


def test_without_a_table_flights_alone_are_compared(tmp_path):
    text = "".join(line for line in SCENE.splitlines(True) if 'name="table"' not in line)
    found = amended(tmp_path, text, {"drag": {"cd": 0.47}})
    shots = few(found.after)
    (said,) = scene_sentences(found.scene, found.after, shots, "scene.xml")
    assert said.startswith("scene.xml, RK4 at 1 ms: 8 shots differ from the list by at most 0.0")
    bouncing = found.after.amended("table_bounce", restitution=0.9, friction=0.2)
    *_, last = scene_sentences(found.scene, bouncing, shots, "scene.xml")
    assert last == "scene.xml has no contact of ball and table, so bounces are not compared."


def test_a_verdict_gives_a_scene_and_code_back_with_their_verification(tmp_path):
    origin = "wind.x: missing before; estimated 0.61 m/s from lab (95 % 0.59 to 0.63)"
    source = file_of(tmp_path, SCENE)
    found = replace(findings(simulator_name=str(source.path)), simulator=does(source))
    handed = handed_over(found)
    assert origin in handed.text and origin in handed.code
    assert handed.sentences[0] == "Changed attributes of lab.xml: wind."
    found = replace(found, handed=handed)
    assert found.details[-len(handed.sentences) :] == list(handed.sentences)
    out = tmp_path / "out"
    write_findings(found, out)
    assert load_scene(str(out / "scene.xml")).model.opt.wind == pytest.approx((0, -0.61, 0))
    assert "200 shots differ from the list by at most" in (out / "report.html").read_text()
    write_findings(replace(found, simulator_name="sim.yaml", handed=None), out)
    assert not (out / "scene.xml").exists() and not (out / "ball_effects.py").exists()
