"""Lists that go into a scene of MuJoCo come back by an audit; what does not fit in is named.

Gravity, buoyancy and added mass act alike, and added mass also divides the forces of the air. So a
list is compared by what MuJoCo can tell apart: its fall as ``gravity.g``, and drag, lift and linear
drag after that division. Values have the ranges that real set-ups have (``observed`` in the
catalogue), or a size that matters in a flight.
"""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.models.audit.audit import NOT_SEPARABLE
from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator
from rallygap.pipeline.engines.audited import audited
from rallygap.pipeline.engines.export.scene.amended_scene import unsupported
from rallygap.pipeline.engines.export.scene.flight import flight_numbers
from rallygap.pipeline.engines.export.scene.verification import VerificationShots
from tests.pipeline.engines.export.scenes import Amended, file_of

TARGET = 0.01  # relative difference that a parameter may have
STEPS = 10  # of time in a contact: with fewer, the restitution scatters
DAMPING = 0.1  # of the contact as it is, over the root of its stiffness
# A vacuum with a table that lies across the world's axes.
MJCF = """<mujoco>
  <option timestep="{step}" integrator="RK4" cone="elliptic"/>
  <worldbody>
    <geom name="table" type="box" size="1.37 .7625 .0125" pos="1 2 .7475"/>
    <body name="ball" pos="1 2 1.5">
      <freejoint/>
      <geom name="ball" type="sphere" size=".02" mass=".0027"/>
    </body>
  </worldbody>
  <contact>
    <pair geom1="table" geom2="ball" condim="3" solref="-{stiffness:.4g} -{damping:.4g}"
      solreffriction="0 -{root:.4g}" solimp=".98 .98 .001"/>
  </contact>
</mujoco>
"""
# Numbers of a flight, and the parameters as which an audit finds them.
FOUND_AS = {
    "fall": "gravity.g",
    "tilt_x": "frame_tilt.x",
    "tilt_y": "frame_tilt.y",
    "wind_x": "wind.x",
    "wind_y": "wind.y",
    "wind_z": "wind.z",
    "drag": "drag.cd",
    "lift": "magnus.cm",
    "linear": "linear_drag.k1",
}


def sizes(low, high):
    return st.floats(low, high)


def signed(low, high):
    return sizes(low, high) | sizes(low, high).map(lambda size: -size)


# Effects that MuJoCo has attributes for; friction is 0 unless a kind of list has it.
WITH_ATTRIBUTE = {
    "gravity.g": sizes(9.78, 9.83),
    "frame_tilt.x": signed(0.0017, 0.0175),
    "frame_tilt.y": signed(0.0017, 0.0175),
    "buoyancy.b": sizes(0.5, 1.5),
    "added_mass.c": sizes(0.5, 1.5),
    "drag.cd": sizes(0.40, 0.56),
    "magnus.cm": sizes(0.07, 0.33),
    "wind.x": signed(0.1, 0.5),
    "wind.y": signed(0.1, 0.5),
    "wind.z": signed(0.1, 0.5),
    "table_bounce.restitution": sizes(0.866, 0.960),
    "table_bounce.friction": st.just(0.0),
}
LITTLE_FRICTION = {"table_bounce.friction": sizes(0.02, 0.05)}
FRICTION = {"table_bounce.friction": sizes(0.15, 0.35)}
# Effects of flight and contact that MuJoCo has no attribute for.
WITHOUT_ATTRIBUTE = {
    "speed_dependent_drag.c": signed(0.03, 0.06),
    "spin_dependent_drag.c": sizes(0.05, 0.1),
    "lift_saturation.kappa": sizes(2.0, 5.0),
    "lift_crisis.d": sizes(0.5, 1.5),
    "side_force.cy": signed(0.01, 0.05),
    "spin_decay.c": sizes(0.003, 0.006),
    "table_height.h": signed(0.001, 0.003),
    "table_tilt.x": signed(0.001, 0.005),
    "table_tilt.y": signed(0.001, 0.005),
    "speed_dependent_restitution.c": sizes(0.004, 0.02),
    "spin_dependent_restitution.c": sizes(0.002, 0.005),
    "slip_dependent_friction.c": sizes(0.004, 0.012),
    "tangential_elasticity.et": sizes(0.05, 0.3),
    "net.restitution": sizes(0.1, 0.3),
    "net.friction": sizes(0.3, 0.6),
    "racket_bounce.restitution": sizes(0.84, 0.91),
    "racket_bounce.speed_loss": sizes(0.015, 0.025),
    "racket_bounce.kp": sizes(1.8e-3, 2.0e-3),
}
ALWAYS = ("gravity", "drag", "table_bounce")  # without drag, wind would hardly show


def lists(ranges):
    """Any list of these effects, of which only some may be left out."""
    effects = {}
    for identity, values in ranges.items():
        effect, name = identity.split(".")
        effects.setdefault(effect, {})[name] = values
    whole = {effect: st.fixed_dictionaries(values) for effect, values in effects.items()}
    always = {effect: whole.pop(effect) for effect in ALWAYS if effect in whole}
    return st.fixed_dictionaries(always, optional=whole)


def amended_scene(folder, step, effects):
    """The plain scene with a list in its attributes, what it did before, and the list."""
    root = math.pi / (STEPS * step)
    text = MJCF.format(step=step, root=root, stiffness=root**2, damping=DAMPING * root)
    return Amended(file_of(folder, text), Simulator.from_dict(effects))


def as_found(effects):
    """The values of a list as an audit can find them."""
    values = {
        f"{effect}.{key}": float(x) for effect, own in effects.items() for key, x in own.items()
    }
    flight = flight_numbers(effects)
    values |= {identity: flight[name] for name, identity in FOUND_AS.items()}
    return {name: value for name, value in values.items() if value and name not in NOT_SEPARABLE}


def check_round_trip(folder, step, effects):
    scene = amended_scene(folder, step, effects).scene
    found = as_found(audited(scene, patience=math.inf).simulator.effects)
    wanted = as_found(effects)
    differences = {name: abs(found.get(name, 0.0) / wanted[name] - 1.0) for name in wanted}
    assert {name: one for name, one in differences.items() if one > TARGET} == {}


def named(folder, effects):
    """What the export says of a list that it cannot write as a whole."""
    found = amended_scene(folder, 1e-3, effects)
    shots = VerificationShots.of(found.after)
    return list(unsupported(found.scene, found.before, found.after, shots))


def test_values_come_back_within_a_percent(tmp_path):
    effects = {
        "gravity": {"g": 9.8},
        "frame_tilt": {"x": 0.01, "y": -0.005},
        "added_mass": {"c": 0.8},
        "drag": {"cd": 0.5},
        "magnus": {"cm": 0.2},
        "wind": {"x": 0.3, "y": -0.2, "z": 0.4},
        "table_bounce": {"restitution": 0.9, "friction": 0.04},
    }
    check_round_trip(tmp_path, 2e-4, effects)


@pytest.mark.slow
@pytest.mark.parametrize(("step", "own"), [(1e-4, {}), (2e-4, {}), (1e-4, LITTLE_FRICTION)])
def test_values_come_back_within_a_percent_for_many_lists(tmp_path_factory, step, own):
    @settings(max_examples=15, deadline=None)
    @given(lists(WITH_ATTRIBUTE | own))
    def many(effects):
        check_round_trip(tmp_path_factory.mktemp("scene"), step, effects)

    many()


@settings(max_examples=4, deadline=None)
@given(lists(WITH_ATTRIBUTE | FRICTION), lists(WITHOUT_ATTRIBUTE))
def test_what_has_no_attribute_is_named(tmp_path_factory, effects, others):
    complete = {"magnus": {"cm": 0.2}, **effects, **others}  # which lift effects need
    said = " ".join(named(tmp_path_factory.mktemp("scene"), complete))
    expected = {f"{effect}.{name}" for effect, values in others.items() for name in values}
    assert {name for name in WITHOUT_ATTRIBUTE if f"{name} " in said} == expected


def test_linear_drag_that_drives_the_ball_is_named(tmp_path):
    effects = {"gravity": {"g": 9.81}, "drag": {"cd": 0.5}, "linear_drag": {"k1": -0.01}}
    assert any("or below 0; viscosity is 0" in sentence for sentence in named(tmp_path, effects))


def test_every_parameter_of_flight_and_contact_is_either_written_or_named():
    known = {
        f"{effect.name}.{parameter.name}"
        for effect in catalogue().values()
        if effect.acts != "sensor"
        for parameter in effect.parameters
    }
    written = WITH_ATTRIBUTE.keys() | {"linear_drag.k1"}
    assert written | WITHOUT_ATTRIBUTE.keys() == known
    assert not written & WITHOUT_ATTRIBUTE.keys()
