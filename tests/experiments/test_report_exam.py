"""Figures and tables of the exam show the numbers that follow from its records."""

import numpy as np
import pytest

from experiments.exam.scoring.rates import covered, of_sweeps, rates
from experiments.report.answers import answer_rows, methods_of
from experiments.report.exam import (
    accuracy_figure,
    confusion_figure,
    coverage_figure,
    effect_table,
    items,
    methods_figure,
)
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.report_items import ReportTable
from tests.experiments.exam.example_records import (
    COMMITTED,
    answer,
    committed,
    hidden,
    named,
    record,
)

RALLYGAP = "rallygap"
RIGHT, MISSED = answer("named", named()), answer("no_gap")


@pytest.fixture(scope="module")
def records():
    return of_sweeps(committed())


def test_the_committed_tables_follow_from_the_committed_records(tmp_path):
    run = StageRun("report_experiments", COMMITTED.parents[2], None)
    tables = [item for item in items(run) if isinstance(item, ReportTable)]
    assert len(tables) == 6
    for table in tables:
        table.write(tmp_path / table.file)
        assert (tmp_path / table.file).read_bytes() == (COMMITTED.parent / table.file).read_bytes()


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
    figure = accuracy_figure(records, [RALLYGAP, "sindy"]).figure
    assert [len(axes.lines) for axes in figure.axes] == [2, 2, 2]
    assert [len(axes.lines[0].get_xdata()) for axes in figure.axes] == [5, 4, 3]
    good, bad = figure.axes[0].lines
    assert (good.get_ydata() > bad.get_ydata()).all()


def test_marks_of_methods_are_at_the_heights_of_their_rates(records):
    axes = methods_figure(records, methods_of(records)).figure.axes[0]
    heights = np.concatenate([line.get_ydata() for line in axes.lines])
    for method in methods_of(records):
        found = rates(records, method)
        for rate in ("false_alarm_rate", "top1_at_3x", "pairs_both", "removable_closed"):
            assert np.abs(heights - 100 * max(found[rate], 0.0)).min() < 1e-3


def test_effects_have_their_marks_at_3_detection_limits():
    similar = hidden(indistinguishable=("frame_tilt.x",))
    given = [record(hidden(), answers=RIGHT), record(hidden(), answers=MISSED)]
    given += [record(similar, answers=RIGHT), record(hidden(), answers=MISSED, cell="size-2x")]
    given += [record(parameters=("wind.x",), not_posed="not shown")]

    (row,) = effect_table(given, RALLYGAP).table.to_dict("records")
    expected = {"hidden": "wind.x", "trials": 3, "distinguishable": 2, "solved": 2, "right": 2}
    assert row == row | expected | {"missed": 1, "wrong": 0, "not_posed": 1}


def test_answers_list_causes_with_their_alternatives():
    possible = ("wind.x", "frame_tilt.x")
    ambiguous = answer("ambiguous", named(estimate=0.31234, possible=possible))
    table = answer_rows([record(hidden(), answers=ambiguous), record(answers=MISSED)], [RALLYGAP])
    assert table["hidden"].tolist() == ["wind.x=0.3", "nothing"]
    assert table["causes"].tolist() == ["wind.x=0.3123 (or frame_tilt.x)", ""]
