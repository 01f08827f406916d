"""Which bytes of a scene change, and what cannot be patched."""

import re

import pytest

from rallygap.models.engines.mujoco.contact import table_contact
from rallygap.pipeline.engines.export.scene.source import SceneSource
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.engines.export.scenes import SCENE, does, patch_of, plain, source_of

COMMENT = re.compile(r"<!-- rallygap: .*? -->(\r?\n *| )", re.DOTALL)
DRAG = {"drag": {"cd": 0.47}}
WIND = {"wind": {"x": 0.5}}
BALL_FILE = """<mujoco><worldbody><body name="ball"><freejoint/><geom type="sphere"
size=".02" mass=".0027"/></body></worldbody></mujoco>"""


def without_comments(text):
    return COMMENT.sub("", text)


def contact_of(scene):
    return table_contact(scene.model, scene.ball, scene.frame)


@pytest.mark.parametrize(
    ("changes", "before", "after"),
    [
        (DRAG, "'.15 0 0 0 .55'", "'0.235 0 0 0 0.55'"),
        ({"magnus": {"cm": 0.12}}, "'.15 0 0 0 .55'", "'0.15 0 0 0 0.62'"),
        ({"gravity": {"g": 9.8}}, '"0 0 -9.81"', '"0 0 -9.8"'),
    ],
)
@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_all_but_the_value_keeps_its_bytes(tmp_path, changes, before, after, line_end):
    text = SCENE.replace("\n", line_end)
    found, _ = patch_of(tmp_path, text, changes)
    head, tail = text.split(before)
    assert without_comments(found.source.text) == head + after + tail
    assert len(found.changes) == 1


def test_nothing_changes_where_the_list_is_what_the_scene_does(tmp_path):
    found, _ = patch_of(tmp_path, SCENE, {})
    assert (found.source.text, found.changes) == (SCENE, ())


def test_comments_have_old_and_new_value_and_the_origin(tmp_path):
    origin = "drag.cd: 0.3 before; estimated 0.47 from lab (95 % 0.46 to 0.48)"
    found, _ = patch_of(tmp_path, SCENE, DRAG, [origin, "wind.x: other"])
    line = next(one for one in found.source.text.splitlines() if "rallygap" in one)
    assert line == (
        f'      <!-- rallygap: fluidcoef was ".15 0 0 0 .55", is "0.235 0 0 0 0.55". {origin} -->'
    )


def test_wind_is_in_the_axes_of_the_world(tmp_path):
    found, _ = patch_of(tmp_path, SCENE, WIND)  # the table's length is along x
    assert found.changes == ("wind",)
    assert 'gravity="0 0 -9.81" wind="0 -0.5 0" />  <!-- tuned by hand -->' in found.source.text


def test_an_option_is_added_where_there_is_none(tmp_path):
    found, _ = patch_of(tmp_path, plain(), WIND | DRAG)
    lines = found.source.text.splitlines()
    assert lines[0] == "<mujoco>"
    assert lines[3] == '  <option wind="0.5 0 0" density="1.2"/><worldbody>'
    assert found.changes == ("wind", "density", "fluidshape", "fluidcoef")


def test_an_option_comes_after_those_of_included_files(tmp_path):
    (tmp_path / "base.xml").write_text('<mujoco><option wind="1 0 0" density="1"/></mujoco>')
    text = plain(head='<include file="base.xml"/>')
    found, _ = patch_of(tmp_path, text, WIND | DRAG)
    assert found.scene.model.opt.wind[0] == 0.5
    assert found.source.text.rstrip().endswith('<option wind="0.5 0 0"/></mujoco>')


def test_an_option_that_an_included_file_overrides_is_refused(tmp_path):
    (tmp_path / "base.xml").write_text('<mujoco><option wind="1 0 0" density="1"/></mujoco>')
    text = plain(head="<option/>", rest='<include file="base.xml"/>')
    with pytest.raises(InputError, match=r"lab.xml: wind would be overridden, by an included"):
        patch_of(tmp_path, text, WIND | DRAG)


def test_a_ball_of_an_included_file_is_refused(tmp_path):
    (tmp_path / "ball.xml").write_text(BALL_FILE)
    text = '<mujoco><option density="1.2"/><include file="ball.xml"/></mujoco>'
    with pytest.raises(InputError, match=r"lab.xml: the geom of the body 'ball' is not written"):
        patch_of(tmp_path, text, DRAG)
    found, _ = patch_of(tmp_path, text, {"gravity": {"g": 9.8}})
    assert found.changes == ("gravity",)


def test_attributes_of_a_default_class_are_overridden_at_the_geom(tmp_path):
    shared = 'mass=".0027" shellinertia="true" fluidshape="ellipsoid" fluidcoef=".5 1 0 1 .6"'
    head = f'<option density="1.2"/><default><geom {shared}/></default>'
    found, _ = patch_of(tmp_path, plain("", head), DRAG)
    assert found.changes == ("fluidcoef",)
    assert '<geom type="sphere" size=".02" fluidcoef="0.235 1 0 1 0.6" />' in found.source.text
    assert f"<default><geom {shared}/></default>" in found.source.text


def test_bodies_and_geoms_without_names_are_found_by_their_place(tmp_path):
    text = SCENE.replace(' name="ball"', "").replace(" name='ball'", "")
    found, _ = patch_of(tmp_path, text, DRAG)
    assert "fluidcoef='0.235 0 0 0 0.55'" in found.source.text


@pytest.mark.parametrize(
    ("flag", "changes", "problem"),
    [
        ('gravity="disable"', {"gravity": {"g": 9.0}}, "switches gravity off"),
        ('spring="disable" damper="disable"', DRAG, "switches all passive forces"),
    ],
)
def test_what_a_flag_switches_off_is_refused(tmp_path, flag, changes, problem):
    with pytest.raises(InputError, match=problem):
        patch_of(tmp_path, plain(head=f"<option><flag {flag}/></option>"), changes)


def test_a_solid_ball_becomes_a_shell_of_the_same_mass(tmp_path):
    found, _ = patch_of(tmp_path, plain('density="80.57" friction="0 0 0"'), {})
    assert found.changes == ("shellinertia", "mass")
    assert found.scene.ball.mass == pytest.approx(0.0027, rel=1e-4)
    assert 'shellinertia="true" mass="0.00269' in found.source.text


def test_a_contact_pair_is_patched_where_there_is_one(tmp_path):
    rest = """<contact>
    <pair geom1='table' geom2="ball" solref="-1000000 -17" friction="0 0 0 0 0"/></contact>"""
    text = SCENE.replace("</worldbody>", f"</worldbody>{rest}")
    found, _ = patch_of(tmp_path, text, {"table_bounce": {"restitution": 0.9, "friction": 0.1}})
    assert set(found.changes) == {"solref", "friction"}
    contact = contact_of(found.scene)
    assert contact.friction == (0.1, 0.1)
    assert contact.restitution == pytest.approx(0.9, abs=0.02)
    assert 'friction="0.1 0.1 0 0 0"' in found.source.text


def test_a_contact_loses_its_friction(tmp_path):
    """MuJoCo keeps a friction of 1e-5, with which the change holds."""
    text = SCENE.replace('friction="0 0 0"', 'friction=".2 .005 .0001"')
    found, _ = patch_of(tmp_path, text, {"table_bounce": {"friction": 0.0}})
    assert found.changes == ("friction",)
    assert contact_of(found.scene).friction[0] < 1e-4


def test_the_table_is_patched_where_the_ball_alone_does_not_decide(tmp_path):
    text = SCENE.replace('pos="1 2 .7475"', 'pos="1 2 .7475" solref="-1000000 -500"')
    found, _ = patch_of(tmp_path, text, {"table_bounce": {"restitution": 0.9}})
    assert found.source.text.count('<!-- rallygap: solref was "-1000000 -500"') == 1
    assert contact_of(found.scene).stiffness == 1e6


def test_an_overridden_contact_is_refused(tmp_path):
    head = '<option o_solref="-1000000 -60"><flag override="enable"/></option>'
    with pytest.raises(InputError, match="neither the pair nor the geoms of ball and table"):
        patch_of(tmp_path, plain(head=head), {"table_bounce": {"restitution": 0.95}})


def test_a_file_that_is_not_in_utf_8_is_refused(tmp_path):
    source_of(tmp_path, SCENE)
    (tmp_path / "lab.xml").write_bytes("<!-- Tische für -->".encode("latin-1"))
    with pytest.raises(InputError, match=r"lab\.xml: is not in UTF-8"):
        SceneSource.read(str(tmp_path / "lab.xml"))


def test_air_that_comes_brings_no_wind_of_an_attribute_without_effect(tmp_path):
    text = plain(head='<option wind="3 0 0"/>')
    found, _ = patch_of(tmp_path, text, DRAG)
    assert "wind" not in does(found.source).effects
