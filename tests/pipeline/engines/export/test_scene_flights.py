"""Amended scenes fly and bounce as the list of effects."""

import numpy as np
import pytest

from rallygap.models.engines.engine import EffectsEngine
from rallygap.pipeline.engines.export.scene.amendment import amend
from rallygap.pipeline.engines.export.scene.verification import (
    AFTER,
    BEFORE,
    FLIGHT,
    VerificationShots,
    distances,
)
from tests.pipeline.engines.export.scenes import SCENE, amended, does, file_of, plain

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
