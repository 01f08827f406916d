"""Tables of the exam contain what its records say."""

import pytest

from rallygap.pipeline.exam.answers import answer_rows, methods_of
from rallygap.pipeline.report.exam_tables import (
    effect_table,
    group_table,
    not_posed_table,
    rate_table,
    robustness_table,
    shortfall_table,
)
from tests.models.exam.example_records import METHODS, answer, example_exam, hidden, named, record

RALLYGAP = "rallygap"
RIGHT, MISSED = answer("named", named()), answer("no_gap")


@pytest.fixture(scope="module")
def records():
    return example_exam()


def test_rates_have_a_column_a_method(records):
    table = rate_table(records).table.set_index("rate")

    assert tuple(table.columns) == METHODS == tuple(methods_of(records))
    assert table.loc["top1_at_3x", "rallygap"] > table.loc["top1_at_3x", "sindy"]


def test_effects_have_their_marks_at_3_detection_limits():
    similar = hidden(indistinguishable=("frame_tilt.x",))
    given = [record(hidden(), answers=RIGHT), record(hidden(), answers=MISSED)]
    given += [record(similar, answers=RIGHT), record(hidden(), answers=MISSED, cell="size-2x")]
    given += [record(parameters=("wind.x",), not_posed="not shown", answers={})]

    (row,) = effect_table(given, RALLYGAP).table.to_dict("records")
    expected = {"hidden": "wind.x", "trials": 3, "distinguishable": 2, "solved": 2, "right": 2}
    assert expected.items() <= row.items()
    assert (row["missed"], row["wrong"], row["not_posed"]) == (1, 0, 1)


def test_groups_count_questions_and_solved_ones(records):
    table = group_table(records, RALLYGAP).table

    assert table["questions"].sum() == len(records)
    assert table["not_posed"].sum() == sum(one.not_posed is not None for one in records)
    assert (table["rallygap"] >= table["sindy"]).mean() > 0.9
    clean = table["group"] == "clean"
    assert table.loc[clean, "removable_closed"].isna().all()
    assert table.loc[table["group"] == "sweep", "removable_closed"].between(0, 1).all()


def test_robustness_has_the_counts_of_every_part():
    clean = {"group": "distortion", "cell": "radial"}
    given = [record(answers=MISSED, **clean), record(answers=RIGHT, **clean)]
    given += [record(hidden(), answers=RIGHT, group="distortion", cell="half")]
    given += [record(hidden(), answers=RIGHT, group="drift", cell=""), record(answers=RIGHT)]

    rows = robustness_table(given, RALLYGAP).table.set_index(["group", "part"])
    assert len(rows) == 3
    assert rows.loc[("distortion", "radial"), ["clean_sets_new", "false_leading"]].tolist() == [
        2,
        1,
    ]
    assert rows.loc[("distortion", "half"), ["constant_new", "leading_right"]].tolist() == [1, 1]
    assert rows.loc[("drift", ""), ["varying_new", "varying_new_right"]].tolist() == [1, 1]
    assert robustness_table([record(answers=RIGHT)], RALLYGAP).table.empty


def test_every_shortfall_is_listed_by_its_trial(records):
    table = shortfall_table(records, RALLYGAP).table
    answers = answer_rows(records, [RALLYGAP])

    assert set(table["trial"]) == set(answers.loc[~answers["solved"], "trial"])
    assert {"missed", "wrong"} >= set(table["mark"])
    assert len(table) > 0


def test_answers_list_causes_with_their_alternatives():
    possible = ("wind.x", "frame_tilt.x")
    ambiguous = answer("ambiguous", named(estimate=0.31234, possible=possible))
    given = [record(hidden(), answers=ambiguous), record(answers=MISSED)]
    table = answer_rows(given, [RALLYGAP])

    assert table["hidden"].tolist() == ["wind.x=0.3", "nothing"]
    assert table["causes"].tolist() == ["wind.x=0.3123 (or frame_tilt.x)", ""]


def test_questions_that_could_not_be_posed_have_a_reason(records):
    table = not_posed_table(records).table

    assert table["questions"].sum() == sum(one.not_posed is not None for one in records)
    assert set(table["reason"]) == {"not shown"}
