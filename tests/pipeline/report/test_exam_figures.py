"""Figures of the exam show the numbers that follow from its records."""

import io

import numpy as np
import pytest

from rallygap.models.exam.scoring.rates import covered, rates
from rallygap.pipeline.report.exam_method import confusion_figure, coverage_figure
from rallygap.pipeline.report.exam_methods import accuracy_figure, methods_figure
from rallygap.pipeline.web.figure_style import apply_style
from tests.models.exam.example_records import METHODS, answer, example_exam, hidden, named, record

RALLYGAP = "rallygap"


@pytest.fixture(scope="module")
def records():
    apply_style()
    return example_exam()


def test_the_confusion_matrix_has_shares_of_what_was_hidden():
    right, wrong = answer("named", named()), answer("named", named("drag.cd"))
    given = [record(hidden(), answers=one) for one in (right, right, right, wrong)]
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


def test_one_record_is_enough_for_all_of_them():
    one = [record(hidden(), answers=answer("no_gap"))]
    for item in (
        confusion_figure(one, RALLYGAP),
        accuracy_figure(one, [RALLYGAP]),
        coverage_figure(one, RALLYGAP),
        methods_figure(one, [RALLYGAP]),
    ):
        item.figure.savefig(io.BytesIO())
