"""Lists that go into a scene of MuJoCo come back; what does not fit into one is named."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rallygap.pipeline.simulator_scenes.round_trip_report as report
from rallygap.models.ball.catalogue import catalogue
from rallygap.pipeline.simulator_scenes.named import named_summary, unsaid_of
from rallygap.pipeline.simulator_scenes.plain_scene import KINDS, Kind
from rallygap.pipeline.simulator_scenes.random_lists import (
    BASE,
    FRICTION,
    LINEAR_DRAG,
    LITTLE_FRICTION,
    NEVER_LEFT_OUT,
    WITHOUT_ATTRIBUTE,
)
from rallygap.pipeline.simulator_scenes.round_trip import RoundTrip, as_found, round_trip

pytest.importorskip("mujoco")

COARSE = Kind(1, 2e-4, own=LITTLE_FRICTION)


def sizes(one):
    ends = st.floats(one.low, one.high)
    return ends | ends.map(lambda size: -size) if one.signed else ends


def lists(ranges):
    """Any list of these effects, of which only some may be left out."""
    effects = {}
    for identity, one in ranges.items():
        effect, name = identity.split(".")
        effects.setdefault(effect, {})[name] = sizes(one)
    always = {name: st.fixed_dictionaries(effects[name]) for name in effects if kept(name)}
    others = {name: st.fixed_dictionaries(effects[name]) for name in effects if not kept(name)}
    return st.fixed_dictionaries(always, optional=others)


def kept(effect):
    return effect in NEVER_LEFT_OUT


def check_round_trip(kind, effects):
    differences = round_trip(kind, effects).differences
    assert {name: one for name, one in differences.items() if one > report.TARGET} == {}


@settings(max_examples=2, deadline=None)
@given(lists(COARSE.ranges))
def test_values_come_back_within_a_percent(effects):
    check_round_trip(COARSE, effects)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["flight and bounce", "contact of 2 ms", "little friction"])
def test_values_come_back_within_a_percent_for_many_lists(name):
    @settings(max_examples=15, deadline=None)
    @given(lists(KINDS[name].ranges))
    def many(effects):
        check_round_trip(KINDS[name], effects)

    many()


@settings(max_examples=10, deadline=None)
@given(lists(BASE | FRICTION), lists(WITHOUT_ATTRIBUTE))
def test_what_has_no_attribute_is_named(effects, others):
    complete = {"magnus": {"cm": 0.2}, **effects, **others}  # which lift effects need
    said = " ".join(unsaid_of(complete))
    expected = {f"{effect}.{name}" for effect, values in others.items() for name in values}
    assert {one for one in WITHOUT_ATTRIBUTE if f"{one} " in said} == expected


@given(st.floats(-1.0, -0.01))
@settings(max_examples=3, deadline=None)
def test_linear_drag_that_drives_the_ball_is_named(k1):
    effects = KINDS["flight and bounce"].effects(0) | {"linear_drag": {"k1": k1}}
    assert any("or below 0; viscosity is 0" in one for one in unsaid_of(effects))


def test_every_parameter_of_flight_and_contact_is_either_written_or_named():
    known = {
        f"{effect.name}.{one.name}"
        for effect in catalogue().values()
        if effect.acts != "sensor"
        for one in effect.parameters
    }
    written = BASE.keys() | LINEAR_DRAG.keys()
    assert written | WITHOUT_ATTRIBUTE.keys() == known
    assert not written & WITHOUT_ATTRIBUTE.keys()


def test_effects_that_act_alike_are_compared_by_what_they_become():
    effects = {"gravity": {"g": 10.0}, "buoyancy": {"b": 1.0}, "drag": {"cd": 0.5}}
    found = as_found(effects)
    assert "buoyancy.b" not in found
    assert found["gravity.g"] == pytest.approx(10.0 * (1.0 - 0.0149), abs=1e-2)
    heavier = as_found(effects | {"added_mass": {"c": 1.0}})
    for name in ("gravity.g", "drag.cd"):
        assert found[name] / heavier[name] == pytest.approx(1.00744, abs=1e-4)


def test_a_parameter_that_the_audit_misses_differs_by_all_of_it():
    trip = RoundTrip({"drag.cd": 0.5, "wind.x": 0.1, "wind.y": 0.0}, {"drag.cd": 0.51})
    assert trip.differences == {"drag.cd": 0.02, "wind.x": 1.0}
    more = RoundTrip({"drag.cd": 0.5}, {"drag.cd": 0.5, "spin_decay.c": 0.01})
    assert more.added == {"spin_decay.c": 0.01}


def test_the_report_has_the_largest_differences(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "KINDS", {"coarse": Kind(2, 5e-4)})
    monkeypatch.setattr(report, "LISTS", 2)
    content = report.round_trips(tmp_path / "scratch")
    coarse = content["kinds"]["coarse"]
    drag = coarse["parameters"]["drag.cd"]
    assert drag["lists"] == coarse["lists"] == 2
    assert drag["within_target"] and drag["largest_difference"] < 1e-3
    assert all(one["named"] == one["lists"] for one in content["without_attribute"].values())
    assert content["without_attribute"]


def test_what_the_export_does_not_name_is_counted():
    found = {"one": {"net.friction": True}, "two": {"net.friction": False}}
    assert named_summary(found) == {"net.friction": {"lists": 2, "named": 1}}
