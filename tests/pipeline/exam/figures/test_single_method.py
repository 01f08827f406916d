"""Figures of the exam show the numbers that follow from its sheets."""

import io

import numpy as np
import pytest

from models.exam.scoring.rates import covered, rates
from pipeline.exam.figures.methods import accuracy_figure, methods_figure
from pipeline.exam.figures.single_method import confusion_figure, coverage_figure
from pipeline.io.figure_style import apply_style
from tests.models.exam.sheets import METHODS, answered, hidden, named, sheet, whole_exam

OURS = "rallygap"


@pytest.fixture(scope="module")
def sheets():
    apply_style()
    return whole_exam()


def image(figure):
    (axes,) = figure.axes
    rows = [label.get_text() for label in axes.get_yticklabels()]
    columns = [label.get_text() for label in axes.get_xticklabels()]
    return rows, columns, axes.images[0].get_array()


def test_the_confusion_matrix_has_shares_of_what_was_hidden():
    right, wrong = answered("named", named()), answered("named", named("drag", "cd"))
    given = [sheet(hidden(), answers=one) for one in (right, right, right, wrong)]
    given += [sheet(group="clean", cell="", answers=answered(one)) for one in ("no_gap", None)]

    rows, columns, shares = image(confusion_figure(given, OURS))
    assert rows == ["wind.x (4)", "nothing (2)"]
    assert columns == ["wind.x", "drag.cd", "no gap", "unknown", "several", "failed"]
    assert shares.tolist() == [[0.75, 0.25, 0, 0, 0, 0], [0, 0, 0.5, 0, 0, 0.5]]


def test_coverage_begins_with_all_intervals(sheets):
    axes = coverage_figure(sheets, OURS).axes[0]
    held = covered(sheets, OURS)

    assert axes.get_yticklabels()[0].get_text() == f"all ({len(held)})"
    dots = [line for line in axes.lines if line.get_marker() == "o"]
    assert dots[0].get_xdata()[0] == pytest.approx(100 * np.mean(held))


def test_accuracy_has_a_panel_for_what_varies_and_a_line_a_method(sheets):
    figure = accuracy_figure(sheets, METHODS)

    assert [len(axes.lines) for axes in figure.axes] == [2, 2, 2]
    assert [len(axes.lines[0].get_xdata()) for axes in figure.axes] == [5, 4, 3]
    good, bad = figure.axes[0].lines
    assert np.mean(good.get_ydata()) > np.mean(bad.get_ydata())


def test_methods_stand_side_by_side_with_their_rates(sheets):
    axes = methods_figure(sheets, METHODS).axes[0]
    heights = {round(bar.get_height(), 3) for bar in axes.patches}

    for method in METHODS:
        found = rates(sheets, method)
        for rate in ("false_alarm_rate", "top1_at_3x", "pairs_both", "removable_closed"):
            assert round(100 * max(found[rate], 0.0), 3) in heights


def test_one_sheet_is_enough_for_all_of_them():
    lone = [sheet(hidden(), answers=answered("no_gap"))]

    for figure in (confusion_figure(lone, OURS), coverage_figure(lone, OURS)):
        figure.savefig(io.BytesIO())
    for figure in (accuracy_figure(lone, [OURS]), methods_figure(lone, [OURS])):
        figure.savefig(io.BytesIO())
