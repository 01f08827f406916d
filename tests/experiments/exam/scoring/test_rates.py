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
WIND_X, DRAG_CD = named("wind.x"), named("drag.cd")
WIND_OR_DRAG = named(possible=("wind.x", "drag.cd"))
EITHER = named("buoyancy.b", possible=CLASS)
CLEAN, WITHHELD = {"group": "clean", "cell": ""}, {"group": "withheld", "withheld": ("wind",)}
DRIFT = {"group": "drift"}


@pytest.mark.parametrize(
    ("truth", "settings", "given", "expected", "is_solved"),
    [
        ([WIND], {}, answer("named", WIND_X), "right", True),
        ([WIND], {}, answer("named", named("wind.y")), "ambiguous", False),
        ([WIND], {}, answer("named", DRAG_CD), "wrong", False),
        ([WIND], {}, answer("named", WIND_X, DRAG_CD), "wrong", False),
        ([WIND], {}, answer("ambiguous", WIND_OR_DRAG), "ambiguous", False),
        ([WIND], {}, answer("named", named(possible=("wind.x", "wind.z"))), "right", True),
        ([WIND], {}, answer("unknown", WIND_X), "wrong", False),
        ([WIND], {}, answer("no_gap"), "missed", False),
        ([WIND], {}, answer(None), "failed", False),
        # Of a cause that is not distinguishable, its class.
        ([GRAVITY], {}, answer("named", named("gravity.g")), "right", True),
        ([GRAVITY], {}, answer("ambiguous", named("gravity.g", possible=CLASS)), "ambiguous", True),
        ([GRAVITY], {}, answer("ambiguous", EITHER), "ambiguous", True),
        ([GRAVITY], {}, answer("named", named("buoyancy.b")), "wrong", False),
        # Two causes together, in any order.
        ([GRAVITY, DRAG], {}, answer("ambiguous", DRAG_CD, EITHER), "ambiguous", True),
        ([GRAVITY, DRAG], {}, answer("ambiguous", EITHER), "wrong", False),
        ([GRAVITY, WIND], {}, answer("ambiguous", DRAG_CD, EITHER), "wrong", False),
        ([], CLEAN, answer("no_gap"), "right", True),
        ([], CLEAN, answer("named"), "wrong", False),
        ([WIND], WITHHELD, answer("unknown"), "right", True),
        ([WIND], WITHHELD, answer("no_gap"), "missed", False),
        ([WIND], WITHHELD, answer("named", WIND_X), "wrong", False),
        # A cause that varies is unknown, or named by its effect.
        ([WIND], DRIFT, answer("unknown"), "right", True),
        ([WIND], DRIFT, answer("named", WIND_X), "right", True),
        ([WIND], DRIFT, answer("ambiguous", named("wind.y")), "right", True),
        ([WIND], DRIFT, answer("unknown", DRAG_CD), "wrong", False),
        ([WIND], DRIFT, answer("named", WIND_X, DRAG_CD), "wrong", False),
        ([WIND], DRIFT, answer("named", WIND_X, MINOR), "right", True),
        ([WIND], DRIFT, answer("no_gap"), "missed", False),
    ],
)
def test_an_answer_has_its_mark(truth, settings, given, expected, is_solved):
    asked = record(*truth, answers=given, **settings)
    assert (mark(asked, RALLYGAP), solved(asked, RALLYGAP)) == (expected, is_solved)


def test_rates_are_counts_of_right_answers():
    """With none in n trials, a rate is at most 1 - 0.05^(1/n) (Clopper and Pearson)."""
    given = [answer("no_gap"), answer("unknown"), answer("named", WIND_X)]
    alarms = rates([record(**CLEAN, answers=one) for one in given], RALLYGAP)
    assert (alarms["clean_sets"], alarms["false_alarms"]) == (3, 2)
    withheld = rates([record(WIND, **WITHHELD, answers=one) for one in given], RALLYGAP)
    assert withheld["unknown_recall"] == pytest.approx(1 / 3, abs=1e-6)
    quiet = rates([record(**CLEAN, answers=answer("no_gap"))] * 500, RALLYGAP)
    assert quiet["false_alarm_rate"] == 0.0
    assert quiet["false_alarm_upper95"] == pytest.approx(1 - 0.05 ** (1 / 500), rel=1e-4)
    assert interval(0, 10)[1] == pytest.approx(1 - 0.025 ** (1 / 10))


def test_coverage_is_of_correctly_named_parameters_at_3_detection_limits_or_more():
    inside, outside = named(estimate=0.29), named(estimate=0.27)
    good, bad = (record(WIND, answers=answer("named", one)) for one in (inside, outside))
    wrong = record(WIND, answers=answer("named", inside, DRAG_CD))
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


def asked(*truth, given, group="distortion"):
    return record(*truth, group=group, cell="gaussian", answers=given)


@pytest.mark.parametrize(
    ("given", "false"),
    [
        (answer("no_gap"), False),
        (answer("unknown"), False),
        (answer("named", SENSOR), False),
        (answer("named", SCALE), False),
        (answer("no_gap", MINOR), False),
        (answer("named", DRAG_CD), True),
        (answer("unknown", DRAG_CD), True),
        (answer("named", SENSOR, DRAG_CD), True),
        (answer(None), True),
    ],
)
def test_without_a_physical_gap_no_physical_cause_may_be_named(given, false):
    found = rates([asked(given=given)], RALLYGAP)
    assert (found["clean_sets_new"], found["false_leading"]) == (1, false)
    assert found["clean_sets"] == 0


@pytest.mark.parametrize(
    ("given", "leads", "exact"),
    [
        (answer("named", WIND_X, DRAG_CD), True, True),
        (answer("named", WIND_X), True, False),
        (answer("named", DRAG_CD), False, False),
        (answer("unknown", WIND_X, DRAG_CD), True, False),
        (answer("named", WIND_X, DRAG_CD, SENSOR), True, True),
        (answer("named", WIND_X, DRAG_CD, named("gravity.g")), True, False),
        (answer("no_gap"), False, False),
    ],
)
def test_the_leading_cause_has_the_largest_effect(given, leads, exact):
    sizes = ((DRAG, 2.0), (WIND, 5.0))
    truth = [cause.model_copy(update={"effect_mm": size}) for cause, size in sizes]
    found = rates([asked(*truth, given=given)], RALLYGAP)
    assert (found["constant_new"], found["leading_right"]) == (1, leads)
    assert (found["exact_right"], found["leading_at_3x"]) == (exact, leads)


def test_faults_of_the_sensor_count_where_it_has_none_and_classes_may_lead():
    given = answer("named", WIND_X, SCALE)
    assert rates([asked(WIND, given=given, group="several")], RALLYGAP)["exact_right"] == 0
    assert rates([asked(WIND, given=given)], RALLYGAP)["exact_right"] == 1
    found = rates([asked(GRAVITY, given=answer("ambiguous", EITHER))], RALLYGAP)
    assert (found["leading_at_3x"], found["exact_at_3x"]) == (1.0, 1.0)


def test_rates_of_groups_do_not_mix_and_those_of_nothing_are_none():
    given = answer("named", WIND_X)
    old, new = record(WIND, answers=given), asked(WIND, given=given)
    varying = record(WIND, answers=given, **DRIFT)
    none, alone, both, more = (
        rates(records, RALLYGAP) for records in ([], [old], [old, new], [old, new, varying])
    )
    later = {name for name in both if both[name] != alone[name]}
    assert later == {
        "constant_new", "leading_right", "leading_at_3x", "exact_right", "exact_at_3x",
        "intervals_new", "intervals_new_right", "coverage_new",
    }  # fmt: skip
    assert both["coverage_new"] == 1.0
    latest = {name for name in more if more[name] != both[name]}
    assert latest == {"varying_new", "varying_new_right", "unknown_recall_new"}
    assert {value for value in none.values() if value != 0} == {None}
