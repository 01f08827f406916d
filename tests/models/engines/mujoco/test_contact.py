"""What the attributes of a contact mean, against bounces in MuJoCo at small steps."""

import math

import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.mujoco.contact import restitution, table_contact
from tests.models.engines.mujoco.scenes import HARD, SHELL, TABLE, pair, scene

STEP = 5e-5
SMALL_STEPS = f'gravity="0 0 0" timestep="{STEP}" integrator="Euler"'
SHIFTS = (-1e-6, -1e-10, 0.0, 1e-10, 1e-6)  # of a damping ratio, above all of a critical one


def contact_of(geom="", option="", table="", rest=""):
    """The contact of a ball and a table with these attributes."""
    one = scene(f"{SHELL} {geom}", option, TABLE.replace("/>", f" {table}/>"), rest)
    return table_contact(one.model, one.ball, one.frame)


def bouncing(solref, solimp=".98 .98 .001"):
    """A scene whose ball and table have this contact, and the contact."""
    both = f'solref="{solref}" solimp="{solimp}" condim="1"'
    one = scene(f"{SHELL} {both}", SMALL_STEPS, TABLE.replace("/>", f" {both}/>"))
    return one, table_contact(one.model, one.ball, one.frame)


def gripping(friction, slip, shell=SHELL, cone="elliptic"):
    """A scene with a contact whose friction has its own damping, and the contact."""
    contact = f'{HARD} solreffriction="{slip}" friction="{friction} {friction} 0 0 0"'
    one = scene(shell, SMALL_STEPS, rest=pair(contact, cone))
    return one, table_contact(one.model, one.ball, one.frame)


def bounced(one, velocity, spin=(0.0, 0.0, 0.0)):
    """Return the (9,) state well after a bounce."""
    launch = np.array([[0.0, -0.5, 0.0205, *velocity, *spin]])
    return one.fly(launch, np.array([0.2]))[0, 0]


@pytest.mark.parametrize(
    ("damping_ratio", "expected"),
    [(0.0, 1.0), (0.0235, 0.930), (0.5, 0.298), (1.0, math.exp(-2.0)), (5.0, 0.0097)],
)
def test_restitution_of_a_spring_and_a_damper(damping_ratio, expected):
    around = [restitution(damping_ratio + shift) for shift in SHIFTS]
    assert around == pytest.approx([expected] * len(SHIFTS), abs=5e-4)
    assert around == sorted(around, reverse=True)


@pytest.mark.parametrize(
    ("solref", "solimp"),
    [
        ("-1000000 -300", ".98 .98 .001"),
        (".01 .2", ".98 .98 .001"),
        (".004 2", ".98 .98 .001"),
        ("-1000000 -47", ".9 .95 .001"),  # an impedance that grows changes little
    ],
)
def test_bounces_have_the_restitution_of_their_solref(solref, solimp):
    one, contact = bouncing(solref, solimp)
    ratio = bounced(one, (0.0, 0.0, -3.0))[5] / 3.0
    assert ratio == pytest.approx(contact.restitution, abs=0.003)


def test_depth_and_duration_of_a_bounce():
    one, contact = bouncing("-1000000 -300")
    launch = np.array([[0.0, -0.5, 0.0205, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0]])
    height = one.fly(launch, STEP * np.arange(400))[0, :, 2] - 0.02
    assert -height.min() == pytest.approx(contact.depth(3.0), rel=0.03)
    # A damped contact ends, still in the table, when it would begin to pull.
    speeds = np.diff(height)
    inside = np.flatnonzero(np.abs(np.diff(speeds)) > 1e-12)
    assert STEP * (inside[-1] - inside[0]) == pytest.approx(contact.duration, rel=0.05)


@pytest.mark.parametrize("spin", [(100.0, 0.0, 30.0), (-150.0, 40.0, 0.0)])
def test_a_ball_that_slides_follows_coulomb(spin):
    velocity = (1.0, 8.0, -3.0)
    one, _ = gripping(0.1, "0 -200")
    flown = bounced(one, velocity, spin)
    law = {"restitution": flown[5] / 3.0, "friction": 0.1}
    before = np.array([[0.0, -0.5, 0.0205, *velocity, *spin]])
    expected = Simulator.from_dict({"table_bounce": law}).fly(before, [0.2]).states[0, 0]
    assert flown[5] / 3.0 == pytest.approx(0.93, abs=0.006)
    np.testing.assert_allclose(flown[3:5], expected[3:5], atol=0.005)
    # Friction acts halfway into the overlap, here 4.5 % nearer to the centre on average.
    turned, wanted = (state[6:8] - spin[:2] for state in (flown, expected))
    assert np.linalg.norm(wanted) > 40.0
    np.testing.assert_allclose(turned, 0.955 * wanted, atol=0.015 * np.linalg.norm(wanted))


@pytest.mark.parametrize(
    ("shell", "cap", "slip_damping"), [(SHELL, 2 / 5, 47), (SHELL, 2 / 5, 1000), ("", 2 / 7, 200)]
)
def test_the_slip_that_a_bounce_ends(shell, cap, slip_damping):
    one, contact = gripping(0.8, f"0 -{slip_damping}", shell)
    flown = bounced(one, (0.0, 1.0, -3.0))
    assert 1.0 - flown[4] == pytest.approx(cap * contact.grip, rel=0.1)


@pytest.mark.parametrize(
    ("slip", "cone", "damping"),
    [("0 0", "elliptic", 47.0), ("0 -200", "pyramidal", 47.0), ("0 -200", "elliptic", 200.0)],
)
def test_slip_has_the_damping_of_the_normal_where_it_has_none_of_its_own(slip, cone, damping):
    assert gripping(0.8, slip, cone=cone)[1].slip_damping == damping


@pytest.mark.parametrize(
    ("geom", "option", "table", "stiffness", "damping"),
    [
        # Geoms of one priority: the mean of standard values, the smaller of direct ones.
        ('solref=".01 .5"', "", 'solref=".03 .5"', 1 / 0.01**2, 100.0),
        ('solref=".01 .5" solmix="3"', "", 'solref=".03 .5"', 1 / 0.0075**2, 2 / 0.015),
        ('solref="-1000 -5"', "", 'solref="-2000 -3"', 2000.0, 5.0),
        ('solref="-1000 -5"', "", "", 1000.0, 5.0),
        ('solref="-1000 -5" priority="1"', "", 'solref="-2000 -3"', 1000.0, 5.0),
        # A pair of signs that does not fit, and a constant below two steps.
        ('solref="-1000 5" priority="1"', "", "", 2500.0, 100.0),
        ('solref=".001 .5" priority="1"', 'timestep=".001"', "", 1 / 0.001**2, 1000.0),
    ],
)
def test_contacts_are_those_that_mujoco_makes(geom, option, table, stiffness, damping):
    contact = contact_of(geom, option, table)
    assert contact.stiffness == pytest.approx(stiffness)
    assert contact.damping == pytest.approx(damping)


def test_flags_override_all_contacts_and_leave_the_time_constant_as_it_is():
    flag = '<option o_solref="-1000 -5"><flag override="enable"/></option>'
    assert contact_of(rest=flag).damping == 5.0
    flag = '<option><flag refsafe="disable"/></option>'
    contact = contact_of('solref=".001 .5" priority="1"', rest=flag)
    assert (contact.damping, contact.raised) == (2000.0, False)


def test_friction_is_the_larger_one_and_none_with_condim_1():
    assert contact_of('friction=".3 0 0"', table='friction=".2 0 0"').friction == (0.3, 0.3)
    assert contact_of('condim="1"', table='condim="1"').friction == (0.0, 0.0)


@pytest.mark.parametrize(
    "option", ['<option><flag contact="disable"', '<option o_solref="0 0"><flag override="enable"']
)
def test_without_a_push_or_a_table_there_is_no_contact(option):
    assert contact_of(rest=f"{option}/></option>") is None
    one = scene(SHELL, table="")
    assert table_contact(one.model, one.ball, one.frame) is None
