"""Figures and tables of the exam show the numbers that follow from its records."""

import numpy as np
import pytest

from experiments.exam.scoring.rates import covered, rates
from experiments.report.answers import answer_rows, methods_of
from experiments.report.exam import (
    accuracy_figure,
    confusion_figure,
    coverage_figure,
    effect_table,
    group_table,
    methods_figure,
    not_posed_table,
    rate_table,
    robustness_table,
    shortfall_table,
)
from tests.experiments.exam.example_records import (
    METHODS,
    answer,
    example_exam,
    hidden,
    named,
    record,
)

RALLYGAP = "rallygap"
RIGHT, MISSED = answer("named", named()), answer("no_gap")


@pytest.fixture(scope="module")
def records():
    return example_exam()


def test_the_confusion_matrix_has_shares_of_what_was_hidden():
    wrong = answer("named", named("drag.cd"))
    given = [record(hidden(), answers=one) for one in (RIGHT, RIGHT, RIGHT, wrong)]
    given += [record(group="clean", cell="", answers=answer(one)) for one in ("no_gap", None)]

    (axes,) = confusion_figure(given, RALLYGAP).figure.axes
    rows = [label.get_text() for label in axes.get_yticklabels()]
    columns = [label.get_text() for label in axes.get_xticklabels()]
    assert rows == ["wind.x (4)", "nothing (2)"]
    assert columns == ["wind.x", "drag.cd", "no gap", "unknown", "several", "failed"]
    shares = axes.images[0].get_array().tolist()
    assert shares == [[0.75, 0.25, 0, 0, 0, 0], [0, 0, 0.5, 0, 0, 0.5]]


def test_coverage_has_all_intervals_first(records):
    axes = coverage_figure(records, RALLYGAP).figure.axes[0]
    contains = covered(records, RALLYGAP)

    assert axes.get_yticklabels()[0].get_text() == f"all ({len(contains)})"
    dots = [line for line in axes.lines if line.get_marker() == "o"]
    assert dots[0].get_xdata()[0] == pytest.approx(100 * np.mean(contains))


def test_accuracy_has_a_panel_a_setting_and_a_line_a_method(records):
    figure = accuracy_figure(records, METHODS).figure

    assert [len(axes.lines) for axes in figure.axes] == [2, 2, 2]
    assert [len(axes.lines[0].get_xdata()) for axes in figure.axes] == [5, 4, 3]
    good, bad = figure.axes[0].lines
    assert np.mean(good.get_ydata()) > np.mean(bad.get_ydata())


def test_marks_of_methods_are_at_the_heights_of_their_rates(records):
    axes = methods_figure(records, METHODS).figure.axes[0]
    heights = {round(float(one), 3) for line in axes.lines for one in line.get_ydata()}

    for method in METHODS:
        found = rates(records, method)
        for rate in ("false_alarm_rate", "top1_at_3x", "pairs_both", "removable_closed"):
            assert round(100 * max(found[rate], 0.0), 3) in heights


@pytest.mark.parametrize("draw", [confusion_figure, coverage_figure])
def test_one_record_is_enough_for_a_figure_of_a_method(draw):
    draw([record(hidden(), answers=MISSED)], RALLYGAP).figure.draw_without_rendering()


@pytest.mark.parametrize("draw", [accuracy_figure, methods_figure])
@pytest.mark.parametrize("given", [MISSED, None])
def test_one_record_is_enough_for_a_figure_of_methods(draw, given):
    draw([record(hidden(), answers=given)], [RALLYGAP]).figure.draw_without_rendering()


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
    assert row == row | expected | {"missed": 1, "wrong": 0, "not_posed": 1}


def test_groups_count_questions_and_solved_ones(records):
    table = group_table(records, RALLYGAP).table

    assert table["questions"].sum() == len(records)
    not_posed = sum(one.not_posed is not None for one in records)
    assert table["not_posed"].sum() == not_posed
    assert not_posed_table(records).table["questions"].sum() == not_posed
    assert set(not_posed_table(records).table["reason"]) == {"not shown"}
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
    for part, columns, counts in (
        (("distortion", "radial"), ["clean_sets_new", "false_leading"], [2, 1]),
        (("distortion", "half"), ["constant_new", "leading_right"], [1, 1]),
        (("drift", ""), ["varying_new", "varying_new_right"], [1, 1]),
    ):
        assert rows.loc[part, columns].tolist() == counts
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
