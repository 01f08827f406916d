"""Tables of the exam say what its sheets say."""

import pytest

from pipeline.exam.tables import (
    answer_table,
    differing,
    effect_table,
    group_table,
    methods_of,
    not_posed_table,
    rate_table,
    shortfall_table,
)
from tests.models.exam.sheets import METHODS, answered, hidden, named, sheet, whole_exam

OURS = "rallygap"
RIGHT, MISSED = answered("named", named()), answered("no_gap")


@pytest.fixture(scope="module")
def sheets():
    return whole_exam()


def test_rates_have_a_row_a_method(sheets):
    table = rate_table(sheets).set_index("method")

    assert tuple(table.index) == METHODS == tuple(methods_of(sheets))
    assert table.loc["rallygap", "top1_at_3x"] > table.loc["sindy", "top1_at_3x"]


def test_effects_have_their_marks_at_3x():
    shared = hidden(alike=("frame_tilt",))
    given = [sheet(hidden(), answers=RIGHT), sheet(hidden(), answers=MISSED)]
    given += [sheet(shared, answers=RIGHT), sheet(hidden(), answers=MISSED, cell="size-2x")]
    given += [sheet(asked=("wind.x",), not_posed="blind", answers={})]

    (row,) = effect_table(given, OURS).to_dict("records")
    expected = {"hidden": "wind.x", "trials": 3, "own_class": 2, "solved": 2, "right": 2}
    assert expected.items() <= row.items()
    assert (row["missed"], row["wrong"], row["not_posed"]) == (1, 0, 1)


def test_groups_count_what_was_asked_and_what_was_solved(sheets):
    table = group_table(sheets, OURS)

    assert table["questions"].sum() == len(sheets)
    assert table["not_posed"].sum() == sum(one.not_posed is not None for one in sheets)
    assert (table["rallygap"] >= table["sindy"]).mean() > 0.9
    clean = table["group"] == "clean"
    assert table.loc[clean, "removable_closed"].isna().all()
    assert table.loc[table["group"] == "sweep", "removable_closed"].between(0, 1).all()


def test_every_shortfall_is_listed_by_its_trial(sheets):
    table = shortfall_table(sheets, OURS)
    answers = answer_table(sheets, [OURS])

    assert set(table["trial"]) == set(answers.loc[~answers["solved"], "trial"])
    assert {"missed", "wrong"} >= set(table["mark"])
    assert len(table) > 0


def test_answers_show_causes_with_what_else_they_may_be():
    doubtful = answered("ambiguous", named(estimate=0.31234, possible=("wind", "frame_tilt")))
    table = answer_table([sheet(hidden(), answers=doubtful), sheet(answers=MISSED)], [OURS])

    assert table["hidden"].tolist() == ["wind.x=0.3", "nothing"]
    assert table["causes"].tolist() == ["wind.x=0.3123 (or frame_tilt)", ""]


def test_what_could_not_be_posed_is_listed_with_the_reason(sheets):
    table = not_posed_table(sheets)

    assert table["questions"].sum() == sum(one.not_posed is not None for one in sheets)
    assert set(table["why"]) == {"not shown"}


def test_answers_agree_if_they_say_the_same_in_other_digits():
    kept = sheet(hidden(), answers=RIGHT)
    digits = sheet(hidden(), answers=answered("named", named(estimate=0.3001)))
    other = sheet(hidden(), answers=answered("named", named("drag", "cd")))

    assert differing([digits], [kept]) == []
    assert differing([other], [kept]) == [kept.name]
    assert differing([digits], []) == [kept.name]
    assert differing([kept], [sheet(hidden(), not_posed="blind", answers={})]) == [kept.name]
