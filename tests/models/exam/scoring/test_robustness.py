"""What counts as right in the robustness groups, and their rates."""

import pytest

from rallygap.models.exam.scoring.rates import mark, rates, solved
from tests.models.exam.example_records import answer, hidden, named, record

RALLYGAP = "rallygap"
WIND, DRAG = hidden("wind.x"), hidden("drag.cd")
SENSOR, SCALE = (
    named("camera_distortion.a").model_copy(update={"role": "sensor"}),
    "position_scale.s",
)
MINOR = named("drag.cd").model_copy(update={"role": "minor"})


def asked(*truth, given, group="distortion", **settings):
    return record(*truth, group=group, cell="gaussian", answers=given, **settings)


@pytest.mark.parametrize(
    ("given", "false"),
    [
        (answer("no_gap"), False),
        (answer("unknown"), False),
        (answer("named", SENSOR), False),
        (answer("named", named(SCALE)), False),
        (answer("no_gap", MINOR), False),
        (answer("named", named("drag.cd")), True),
        (answer("unknown", named("drag.cd")), True),
        (answer("named", SENSOR, named("drag.cd")), True),
        (answer(None), True),
    ],
)
def test_without_a_physical_gap_no_physical_cause_may_be_named(given, false):
    clean = asked(given=given)

    found = rates([clean], RALLYGAP)
    assert (found["clean_sets_new"], found["false_leading"]) == (1, false)
    assert solved(clean, RALLYGAP) is not false
    assert found["clean_sets"] == 0


@pytest.mark.parametrize("group", ["drift", "shot_variation", "place"])
@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (answer("unknown"), "right"),
        (answer("named", named("wind.x")), "right"),
        (answer("ambiguous", named("wind.y")), "right"),
        (answer("unknown", named("drag.cd")), "wrong"),
        (answer("named", named("wind.x"), named("drag.cd")), "wrong"),
        (answer("named", named("wind.x"), MINOR), "right"),
        (answer("no_gap"), "missed"),
        (answer(None), "failed"),
    ],
)
def test_a_cause_that_varies_is_unknown_or_named_by_its_effect(group, given, expected):
    varying = asked(WIND, given=given, group=group)

    assert mark(varying, RALLYGAP) == expected
    assert solved(varying, RALLYGAP) == (expected == "right")
    found = rates([varying], RALLYGAP)
    assert (found["varying_new"], found["varying_new_right"]) == (1, expected == "right")
    assert found["constant_new"] == found["intervals_new"] == 0


@pytest.mark.parametrize(
    ("given", "leads", "exact"),
    [
        (answer("named", named("wind.x"), named("drag.cd")), True, True),
        (answer("named", named("wind.x")), True, False),
        (answer("named", named("drag.cd")), False, False),
        (answer("unknown", named("wind.x"), named("drag.cd")), True, False),
        (answer("named", named("wind.x"), named("drag.cd"), SENSOR), True, True),
        (answer("named", named("wind.x"), named("drag.cd"), named("gravity.g")), True, False),
        (answer("no_gap"), False, False),
    ],
)
def test_the_leading_cause_has_the_largest_effect(given, leads, exact):
    truth = [
        cause.model_copy(update={"effect_mm": size}) for cause, size in ((DRAG, 2.0), (WIND, 5.0))
    ]
    found = rates([asked(*truth, given=given)], RALLYGAP)

    assert (found["constant_new"], found["leading_right"]) == (1, leads)
    assert found["exact_right"] == exact
    assert found["leading_at_3x"] == float(leads)


def test_a_leading_cause_that_is_not_distinguishable_is_named_by_its_class():
    gravity = hidden("gravity.g", indistinguishable=("buoyancy.b",))
    given = answer("ambiguous", named("buoyancy.b", possible=("buoyancy.b", "gravity.g")))

    found = rates([asked(gravity, given=given)], RALLYGAP)
    assert (found["leading_at_3x"], found["exact_at_3x"]) == (1.0, 1.0)


def test_faults_of_the_sensor_count_where_the_sensor_has_none():
    given = answer("named", named("wind.x"), named(SCALE))

    assert rates([asked(WIND, given=given, group="several")], RALLYGAP)["exact_right"] == 0
    assert rates([asked(WIND, given=given)], RALLYGAP)["exact_right"] == 1


def test_rates_of_both_kinds_of_groups_do_not_mix():
    given = answer("named", named("wind.x"))
    old = record(WIND, answers=given)
    new = asked(WIND, given=given)
    both, alone = rates([old, new], RALLYGAP), rates([old], RALLYGAP)

    later = [name for name in both if both[name] != alone[name]]
    assert set(later) == {
        "constant_new", "leading_right", "leading_at_3x", "exact_right", "exact_at_3x",
        "intervals_new", "intervals_new_right", "coverage_new",
    }  # fmt: skip
    assert both["coverage_new"] == 1.0


def test_rates_of_groups_without_a_record_are_none():
    found = rates([record(WIND, answers=answer("no_gap"))], RALLYGAP)

    names = ("false_leading_rate", "leading_at_3x", "exact_at_3x", "coverage_new")
    assert all(found[name] is None for name in (*names, "unknown_recall_new"))
