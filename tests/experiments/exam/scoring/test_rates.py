"""Marks of answers, and the rates that follow."""

import pytest

from experiments.exam.scoring.rates import covered, interval, mark, rates, removable_gap, solved
from tests.experiments.exam.example_records import answer, hidden, named, record

WIND, DRAG = hidden("wind.x"), hidden("drag.cd")
GRAVITY = hidden("gravity.g", indistinguishable=("buoyancy.b",))
CLASS = ("gravity.g", "buoyancy.b")
RALLYGAP = "rallygap"
SENSOR = named("camera_distortion.a").model_copy(update={"role": "sensor"})
SCALE = named("position_scale.s")
MINOR = named("drag.cd").model_copy(update={"role": "minor"})


@pytest.mark.parametrize(
    ("truth", "given", "expected", "is_solved"),
    [
        (WIND, answer("named", named("wind.x")), "right", True),
        (WIND, answer("named", named("wind.y")), "ambiguous", False),
        (WIND, answer("named", named("drag.cd")), "wrong", False),
        (WIND, answer("named", named("wind.x"), named("drag.cd")), "wrong", False),
        (WIND, answer("ambiguous", named(possible=("wind.x", "frame_tilt.x"))), "ambiguous", False),
        (WIND, answer("named", named(possible=("wind.x", "wind.z"))), "right", True),
        (WIND, answer("unknown", named("wind.x")), "wrong", False),
        (WIND, answer("no_gap"), "missed", False),
        (WIND, answer(None), "failed", False),
        (GRAVITY, answer("named", named("gravity.g")), "right", True),
        (GRAVITY, answer("ambiguous", named("gravity.g", possible=CLASS)), "ambiguous", True),
        (GRAVITY, answer("ambiguous", named("buoyancy.b", possible=CLASS)), "ambiguous", True),
        (GRAVITY, answer("named", named("buoyancy.b")), "wrong", False),
    ],
)
def test_a_cause_that_is_distinguishable_or_not(truth, given, expected, is_solved):
    asked = record(truth, answers=given)
    assert (mark(asked, RALLYGAP), solved(asked, RALLYGAP)) == (expected, is_solved)


def test_two_causes_are_solved_together_in_any_order():
    both = [named("drag.cd"), named("buoyancy.b", possible=CLASS)]

    assert solved(record(GRAVITY, DRAG, answers=answer("ambiguous", *both)), RALLYGAP)
    assert not solved(record(GRAVITY, DRAG, answers=answer("ambiguous", both[1])), RALLYGAP)
    assert not solved(record(GRAVITY, WIND, answers=answer("ambiguous", *both)), RALLYGAP)


@pytest.mark.parametrize(
    ("conclusion", "expected"),
    [("no_gap", "right"), ("unknown", "wrong"), ("named", "wrong"), (None, "failed")],
)
def test_on_a_clean_set_every_answer_but_no_gap_is_a_false_alarm(conclusion, expected):
    clean = record(group="clean", cell="", answers=answer(conclusion))

    assert mark(clean, RALLYGAP) == expected
    assert rates([clean], RALLYGAP)["false_alarms"] == (conclusion != "no_gap")


def test_with_a_withheld_effect_only_unknown_is_right():
    answers = [answer("unknown"), answer("no_gap"), answer("named", named("wind.x"))]
    settings = {"group": "withheld", "withheld": ("wind",)}
    records = [record(WIND, answers=given, **settings) for given in answers]

    assert [solved(one, RALLYGAP) for one in records] == [True, False, False]
    assert rates(records, RALLYGAP)["unknown_recall"] == pytest.approx(1 / 3, abs=1e-6)


def test_false_alarms_have_a_clopper_pearson_bound():
    """None in n trials bounds a rate by 1 - 0.05^(1/n)."""
    found = rates([record(group="clean", answers=answer("no_gap"))] * 500, RALLYGAP)

    assert found["false_alarm_rate"] == 0.0
    assert found["false_alarm_upper95"] == pytest.approx(1 - 0.05 ** (1 / 500), rel=1e-4)
    assert interval(0, 10)[1] == pytest.approx(1 - 0.025 ** (1 / 10))


def test_coverage_is_of_correctly_named_parameters_at_3_detection_limits_or_more():
    inside, outside = named(estimate=0.29), named(estimate=0.27)
    good, bad = (record(WIND, answers=answer("named", one)) for one in (inside, outside))
    wrong = record(WIND, answers=answer("named", inside, named("drag.cd")))
    small = record(WIND, answers=answer("named", inside), multiple=2.0)
    bare = record(WIND, answers=answer("named", named(margin=None)))

    assert covered([good, bad, wrong, small, bare], RALLYGAP) == [True, False]


def test_the_removable_gap_is_a_ratio_of_sums_and_failures_close_nothing():
    large = record(WIND, before=30.0, answers=answer("named", named(), after=0.0))
    small = record(WIND, before=10.0, answers=answer("no_gap", after=10.0))
    failed = record(WIND, before=20.0, answers=answer(None, after=None))
    withheld = record(WIND, withheld=("wind",), answers=answer("unknown"))
    clean = record(answers=answer("no_gap"))

    assert removable_gap([large, small, failed, withheld, clean], RALLYGAP) == (3, 60.0, 30.0)
    assert rates([large, small, failed], RALLYGAP)["removable_closed"] == 0.5


def test_rates_at_3_detection_limits_are_of_the_base_only():
    right, missed = answer("named", named()), answer("no_gap")
    records = [record(WIND, answers=one) for one in (right, right, right, missed)]
    records += [record(GRAVITY, answers=answer("named", named("gravity.g")))]
    records += [record(WIND, answers=missed, cell="shots-10")]

    found = rates(records, RALLYGAP)
    assert (found["distinguishable"], found["top1_at_3x"]) == (4, 0.75)
    assert (found["indistinguishable"], found["class_at_3x"]) == (1, 1.0)


def asked(*truth, given, group="distortion", **settings):
    return record(*truth, group=group, cell="gaussian", answers=given, **settings)


@pytest.mark.parametrize(
    ("given", "false"),
    [
        (answer("no_gap"), False),
        (answer("unknown"), False),
        (answer("named", SENSOR), False),
        (answer("named", SCALE), False),
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


def test_faults_of_the_sensor_count_where_it_has_none_and_classes_may_lead():
    given = answer("named", named("wind.x"), SCALE)

    assert rates([asked(WIND, given=given, group="several")], RALLYGAP)["exact_right"] == 0
    assert rates([asked(WIND, given=given)], RALLYGAP)["exact_right"] == 1
    given = answer("ambiguous", named("buoyancy.b", possible=CLASS))
    found = rates([asked(GRAVITY, given=given)], RALLYGAP)
    assert (found["leading_at_3x"], found["exact_at_3x"]) == (1.0, 1.0)


def test_rates_of_both_kinds_of_groups_do_not_mix_and_those_of_nothing_are_none():
    given = answer("named", named("wind.x"))
    old, new = record(WIND, answers=given), asked(WIND, given=given)
    none, alone, both = (rates(records, RALLYGAP) for records in ([], [old], [old, new]))

    later = {name for name in both if both[name] != alone[name]}
    assert later == {
        "constant_new", "leading_right", "leading_at_3x", "exact_right", "exact_at_3x",
        "intervals_new", "intervals_new_right", "coverage_new",
    }  # fmt: skip
    assert both["coverage_new"] == 1.0
    assert {value for value in none.values() if value != 0} == {None}
    assert none["coverage"] is none["unknown_recall_new"] is none["false_alarm_upper95"] is None
