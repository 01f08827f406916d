"""Scoring: what an answer is worth, and the rates that follow."""

import pytest

from models.exam.scoring.rates import closed, covered, interval, mark, rates, solved
from tests.models.exam.sheets import answered, hidden, named, sheet

WIND, DRAG = hidden("wind", "x"), hidden("drag", "cd")
GRAVITY = hidden("gravity", "g", alike=("buoyancy",))
FAMILY = ("gravity", "buoyancy")
OURS = "rallygap"


@pytest.mark.parametrize(
    ("answer", "expected", "is_solved"),
    [
        (answered("named", named("wind", "x")), "right", True),
        (answered("named", named("wind", "y")), "ambiguous", False),
        (answered("named", named("drag", "cd")), "wrong", False),
        (answered("named", named("wind", "x"), named("drag", "cd")), "wrong", False),
        (answered("ambiguous", named(possible=("wind", "frame_tilt"))), "ambiguous", False),
        (answered("unknown", named("wind", "x")), "wrong", False),
        (answered("no_gap"), "missed", False),
        (answered(None), "failed", False),
    ],
)
def test_one_cause_that_is_a_class_of_its_own(answer, expected, is_solved):
    given = sheet(WIND, answers=answer)

    assert (mark(given, OURS), solved(given, OURS)) == (expected, is_solved)


@pytest.mark.parametrize(
    ("answer", "expected", "is_solved"),
    [
        (answered("named", named("gravity", "g")), "right", True),
        (answered("ambiguous", named("gravity", "g", possible=FAMILY)), "ambiguous", True),
        (answered("ambiguous", named("buoyancy", "b", possible=FAMILY[::-1])), "ambiguous", True),
        (answered("named", named("buoyancy", "b")), "wrong", False),
    ],
)
def test_one_cause_that_shares_its_class(answer, expected, is_solved):
    given = sheet(GRAVITY, answers=answer)

    assert (mark(given, OURS), solved(given, OURS)) == (expected, is_solved)


def test_two_causes_are_solved_together_in_any_order():
    both = [named("drag", "cd"), named("buoyancy", "b", possible=FAMILY)]

    assert solved(sheet(GRAVITY, DRAG, answers=answered("ambiguous", *both)), OURS)
    assert not solved(sheet(GRAVITY, DRAG, answers=answered("ambiguous", both[1])), OURS)
    assert not solved(sheet(GRAVITY, WIND, answers=answered("ambiguous", *both)), OURS)


@pytest.mark.parametrize(
    ("answer", "expected"),
    [("no_gap", "right"), ("unknown", "wrong"), ("named", "wrong"), (None, "failed")],
)
def test_on_a_clean_set_every_answer_but_no_gap_is_a_false_alarm(answer, expected):
    clean = sheet(group="clean", cell="", answers=answered(answer))
    found = rates([clean], OURS)

    assert mark(clean, OURS) == expected
    assert found["false_alarms"] == (answer != "no_gap")


def test_where_an_effect_was_withheld_only_unknown_is_right():
    def withheld(answer):
        settings = {"group": "withheld", "withheld": ("wind",), "answers": answered(*answer)}
        return sheet(WIND, **settings)

    sheets = [withheld(one) for one in (("unknown",), ("no_gap",), ("named", named("wind", "x")))]
    assert [solved(one, OURS) for one in sheets] == [True, False, False]
    assert rates(sheets, OURS)["unknown_recall"] == pytest.approx(1 / 3, abs=1e-6)


def test_false_alarms_have_a_clopper_pearson_bound():
    """None in n trials bounds a rate by 1 - 0.05^(1/n)."""
    found = rates([sheet(group="clean", answers=answered("no_gap"))] * 500, OURS)

    assert found["false_alarm_rate"] == 0.0
    assert found["false_alarm_upper95"] == pytest.approx(1 - 0.05 ** (1 / 500), rel=1e-4)
    assert interval(0, 10)[1] == pytest.approx(1 - 0.025 ** (1 / 10))


def test_coverage_pools_rightly_named_numbers_at_three_times_or_more():
    inside, outside = named(estimate=0.29), named(estimate=0.27)
    good, bad = (sheet(WIND, answers=answered("named", one)) for one in (inside, outside))
    wrong = sheet(WIND, answers=answered("named", inside, named("drag", "cd")))
    small = sheet(WIND, answers=answered("named", inside), multiple=2.0)
    bare = sheet(WIND, answers=answered("named", named(spread=None)))

    assert covered([good, bad, wrong, small, bare], OURS) == [True, False]


def test_the_removable_gap_is_a_ratio_of_sums_and_failures_close_nothing():
    large = sheet(WIND, before=30.0, answers=answered("named", named(), after=0.0))
    small = sheet(WIND, before=10.0, answers=answered("no_gap", after=10.0))
    failed = sheet(WIND, before=20.0, answers=answered(None, after=None))
    apart = sheet(WIND, withheld=("wind",), answers=answered("unknown"))
    clean = sheet(answers=answered("no_gap"))

    assert closed([large, small, failed, apart, clean], OURS) == (3, 60.0, 30.0)
    assert rates([large, small, failed], OURS)["removable_closed"] == 0.5


def test_names_and_classes_at_3x_are_counted_apart_and_of_the_base_alone():
    right, missed = answered("named", named()), answered("no_gap")
    sheets = [sheet(WIND, answers=one) for one in (right, right, right, missed)]
    sheets += [sheet(GRAVITY, answers=answered("named", named("gravity", "g")))]
    sheets += [sheet(WIND, answers=missed, cell="shots-10")]

    found = rates(sheets, OURS)
    assert (found["own_class"], found["top1_at_3x"]) == (4, 0.75)
    assert (found["shared_class"], found["class_at_3x"]) == (1, 1.0)


def test_rates_of_nothing_are_none():
    found = rates([sheet(WIND, answers={})], OURS)

    assert found["trials"] == 0
    assert found["coverage"] is found["false_alarm_upper95"] is found["removable_closed"] is None
