"""Which attributes of a scene change, what stays, and how amended scenes fly and bounce."""

import re

import numpy as np
import pytest

from rallygap.models.engines.engine import EffectsEngine
from rallygap.models.engines.mujoco.contact import table_contact
from rallygap.pipeline.engines.export.scene.amendment import SceneFile, amend
from rallygap.pipeline.engines.export.scene.verification import (
    AFTER,
    BEFORE,
    FLIGHT,
    VerificationShots,
    distances,
)
from rallygap.pipeline.engines.load import load_scene
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.engines.export.scenes import POST, SCENE, amended, does, file_of, plain

DRAG = {"drag": {"cd": 0.47}}
WIND = {"wind": {"x": 0.5}}
BALL_FILE = """<mujoco><worldbody><body name="ball"><freejoint/><geom type="sphere"
size=".02" mass=".0027"/></body></worldbody></mujoco>"""


def contact_of(scene):
    return table_contact(scene.model, scene.ball, scene.frame)


@pytest.mark.parametrize(
    ("changes", "before", "after"),
    [
        (DRAG, "'.15 0 0 0 .55'", "'0.235 0 0 0 0.55'"),
        ({"magnus": {"cm": 0.12}}, "'.15 0 0 0 .55'", "'0.15 0 0 0 0.62'"),
        ({"gravity": {"g": 9.8}}, '"0 0 -9.81"', '"0 0 -9.8"'),
        (WIND, 'gravity="0 0 -9.81"', 'wind="0 -.5 0"'),  # the table's length is along x
    ],
)
def test_all_but_the_value_stays(tmp_path, changes, before, after):
    found = amended(tmp_path, SCENE, changes)
    expected = file_of(tmp_path, SCENE.replace(before, after))
    assert len(found.changes) == 1
    assert found.scene.content == expected.scene().content


def test_where_nothing_changes_the_written_scene_has_what_its_file_has(tmp_path):
    (tmp_path / "base.xml").write_text('<mujoco><option wind="1 0 0" density="1"/></mujoco>')
    (tmp_path / "shapes").mkdir()
    (tmp_path / "shapes" / "post.obj").write_text(POST)
    head = (
        '<compiler meshdir="shapes" angle="degree"/><include file="base.xml"/>'
        '<default><default class="soft"><geom solref=".03 1"/></default></default>'
        '<asset><mesh name="post" file="post.obj"/></asset>'
    )
    more = '<geom class="soft" type="mesh" mesh="post" pos="3 0 0" euler="0 0 30"/>'
    rest = f'<worldbody>{more}<replicate count="2" offset="1 0 0"><geom size=".1"/></replicate>'
    text = plain(head=head, rest=f"{rest}</worldbody>")
    found = amended(tmp_path, text, {})
    assert found.changes == ()
    assert found.scene.content == load_scene(str(tmp_path / "lab.xml")).content
    assert 'euler="0 0 30"' in found.text and '<default class="soft">' in found.text
    assert "<freejoint/>" in found.text


def test_the_head_has_old_and_new_values_their_origin_and_the_file_s_comment(tmp_path):
    origin = "drag.cd: 0.3 before; estimated 0.47 from lab (95 % 0.46 to 0.48)"
    text = SCENE.replace("<option time", "<!-- our lab --><option time")
    found = amended(tmp_path, text, DRAG, [origin, "wind.x: other"])
    (said,) = found.sentences
    assert said.endswith(f'was "0.15 0 0 0 0.55", is "0.235 0 0 0 0.55". {origin}')
    (comment,) = re.findall("<!--(.*?)-->", found.text, re.DOTALL)
    assert f"rallygap: {said}" in comment and "our lab" in comment


@pytest.mark.parametrize(
    "hostile", ['--> <option wind="9 0 0"/> <!--', "-----", "&lt; \x1b[2J \udcff", "--\n-->"]
)
def test_text_of_a_list_stays_in_the_comment(tmp_path, hostile):
    found = amended(tmp_path, SCENE, DRAG, [f"drag.cd: {hostile}"])
    (tmp_path / "out.xml").write_text(found.text, encoding="utf-8")
    assert found.text.count("-->") == 1
    assert load_scene(str(tmp_path / "out.xml")).content == found.scene.content


@pytest.mark.parametrize("place", ["head", "rest"])
def test_options_and_balls_of_included_files_are_amended(tmp_path, place):
    (tmp_path / "base.xml").write_text('<mujoco><option wind="1 0 0" density="1"/></mujoco>')
    found = amended(tmp_path, plain(**{place: '<include file="base.xml"/>'}), WIND | DRAG)
    assert found.scene.model.opt.wind[0] == 0.5 and found.scene.model.opt.density == 1.0
    (tmp_path / "ball.xml").write_text(BALL_FILE)
    text = '<mujoco><option density="1.2"/><include file="ball.xml"/></mujoco>'
    assert amended(tmp_path, text, DRAG).changes == ("fluidshape", "fluidcoef")


def test_attributes_of_a_default_class_are_overridden_at_the_geom(tmp_path):
    shared = 'mass=".0027" shellinertia="true" fluidshape="ellipsoid" fluidcoef=".5 1 0 1 .6"'
    head = f'<option density="1.2"/><default><geom {shared}/></default>'
    found = amended(tmp_path, plain("", head), DRAG)
    assert found.changes == ("fluidcoef",)
    model, ball = found.scene.model, found.scene.ball.geom
    np.testing.assert_allclose(model.geom_fluid[ball, 1:6], [0.235, 1.0, 0.0, 1.0, 0.6])
    assert model.geom_fluid[1 - ball, 1] == 0.5


@pytest.mark.parametrize(
    ("head", "changes", "problem"),
    [
        ('<option><flag gravity="disable"/></option>', {"gravity": {"g": 9.0}}, "gravity off"),
        (
            '<option o_solref="-1000000 -60"><flag override="enable"/></option>',
            {"table_bounce": {"restitution": 0.95}},
            "neither the pair nor the geoms of ball and table",
        ),
    ],
)
def test_what_a_flag_switches_off_or_overrides_is_refused(tmp_path, head, changes, problem):
    with pytest.raises(InputError, match=problem):
        amended(tmp_path, plain(head=head), changes)


def test_a_solid_ball_becomes_a_shell_of_the_same_mass(tmp_path):
    found = amended(tmp_path, plain('density="80.57" friction="0 0 0"'), {})
    assert found.changes == ("shellinertia", "mass")
    assert found.scene.ball.mass == pytest.approx(0.0027, rel=1e-4)
    inertia = found.scene.model.body_inertia[found.scene.ball.body]
    assert inertia == pytest.approx(2 / 3 * 0.0027 * 0.02**2, rel=1e-4)


def test_a_contact_pair_is_amended_where_there_is_one(tmp_path):
    rest = """<contact>
    <pair geom1='table' geom2="ball" solref="-1000000 -17" friction="0 0 0 0 0"/></contact>"""
    text = SCENE.replace("</worldbody>", f"</worldbody>{rest}")
    found = amended(tmp_path, text, {"table_bounce": {"restitution": 0.9, "friction": 0.1}})
    assert set(found.changes) == {"solref", "friction"}
    contact = contact_of(found.scene)
    assert contact.friction == (0.1, 0.1)
    assert contact.restitution == pytest.approx(0.9, abs=0.02)
    assert found.scene.model.pair_friction[0].tolist() == [0.1, 0.1, 0.0, 0.0, 0.0]


def test_a_contact_loses_its_friction(tmp_path):
    """MuJoCo keeps a friction of 1e-5, with which the change holds."""
    text = SCENE.replace('friction="0 0 0"', 'friction=".2 .005 .0001"')
    found = amended(tmp_path, text, {"table_bounce": {"friction": 0.0}})
    assert found.changes == ("friction",)
    assert contact_of(found.scene).friction[0] < 1e-4


def test_the_table_is_amended_where_the_ball_alone_does_not_decide(tmp_path):
    text = SCENE.replace('pos="1 2 .7475"', 'pos="1 2 .7475" solref="-1000000 -500"')
    found = amended(tmp_path, text, {"table_bounce": {"restitution": 0.9}})
    assert found.changes == ("solref",) and len(found.sentences) == 2
    assert contact_of(found.scene).stiffness == 1e6


def test_a_name_that_is_not_in_utf_8_is_refused(tmp_path):
    path = tmp_path / "lab.xml"
    path.write_bytes(plain(head="<!-- Tisch für -->").encode("latin-1"))
    with pytest.raises(InputError, match=r"lab\.xml: MuJoCo cannot read it: 'utf-8' codec"):
        SceneFile.read(str(path))


def test_air_that_comes_brings_no_wind_of_an_attribute_without_effect(tmp_path):
    found = amended(tmp_path, plain(head='<option wind="3 0 0"/>'), DRAG)
    assert not found.scene.model.opt.wind.any()


# Contacts that are short: a bounce of 3 m/s comes late by 2.8 mm per millisecond of contact.
STIFF = SCENE.replace("-1000000 -30", "-36000000 -180").replace('"0.001"', '"0.00002"')
SMOOTH = '<option integrator="RK4" timestep=".001"/>'


def flight_error(found):
    """Largest distance in mm after 0.6 s, over 20 shots."""
    flights = VerificationShots.of(found.after).flights[::10]
    return distances(found.scene, EffectsEngine("list", found.after), flights, FLIGHT).max()


@pytest.mark.parametrize(
    "changes",
    [
        {"wind": {"x": 0.5, "y": -1.0, "z": 0.3}, "magnus": {"cm": -0.2}},
        {"gravity": {"g": 9.7}, "frame_tilt": {"x": 0.03, "y": -0.02}, "drag": {"cd": 0.55}},
        {"buoyancy": {"b": 1.0}, "added_mass": {"c": 1.0}},
        {"linear_drag": {"k1": 0.1}, "magnus": {"cm": 0.0}},  # exact without spin or lift
        {"wind": {"x": 1.0}, "drag": {"cd": 0.4}, "magnus": {"cm": 0.3}, "frame_tilt": {"y": 0.1}},
    ],
)
@pytest.mark.parametrize("text", [SCENE, plain(head=SMOOTH)], ids=["turned", "plain"])
def test_flights_are_those_of_the_list(tmp_path, text, changes):
    assert flight_error(amended(tmp_path, text, changes)) < 0.02


def test_what_is_not_changed_keeps_what_the_time_step_makes_of_it(tmp_path):
    """A list that an audit finds may have errors of integration; they stay out of attributes."""
    file = file_of(tmp_path, plain(head='<option timestep=".004" density="1.2"/>'))
    before = does(file).amended("gravity", g=9.85)
    amendments = amend(file, before, before.amended("drag", cd=0.47), [])
    assert "gravity" not in [amendment.attribute for amendment in amendments]


def test_bounces_are_those_of_the_list(tmp_path):
    found = amended(tmp_path, STIFF, {"table_bounce": {"restitution": 0.93}})
    states = VerificationShots.of(found.after).bounces[::10]
    sizes = distances(found.scene, EffectsEngine("list", found.after), states, BEFORE + AFTER)
    assert found.changes == ("solref",)
    assert len(states) > 10
    assert np.quantile(sizes, 0.95) < 3.0 and sizes.max() < 4.0  # restitutions scatter by .002


@pytest.mark.parametrize(
    ("step", "solimp", "tolerance"), [(5e-4, "", 0.01), (2e-3, 'solimp=".5 .95 .002"', 0.02)]
)
def test_the_restitution_is_solved_for_the_scene(tmp_path, step, solimp, tolerance):
    """The default contact becomes stiffer; at 2 ms, its impedance and the steps matter."""
    ball = f'mass=".0027" shellinertia="true" friction="0 0 0" {solimp}'
    text = plain(ball, f'<option timestep="{step}" integrator="RK4"/>')
    found = amended(tmp_path, text, {"table_bounce": {"restitution": 0.9}})
    speeds = np.linspace(1.5, 4.5, 60)
    launches = np.zeros((60, 9))
    launches[:, 1], launches[:, 2], launches[:, 5] = 0.7, 0.021, -speeds
    left = found.scene.fly(launches, np.array([0.05]))[:, 0, 5] + 9.81 * 0.05
    assert (left / speeds).mean() == pytest.approx(0.9, abs=tolerance)
