"""Figures of many verdicts show the numbers they were given."""

import numpy as np
import pytest

from rallygap.pipeline.gap.figures import LINE_NAMES, LINES
from rallygap.pipeline.report.close_gap import closing_figure, stability_figure
from rallygap.pipeline.web.figure_style import apply_style
from tests.pipeline.verdicts import CAMERA, GAP, GRAVITY, MINOR, WIND, diagnosed, verdict


@pytest.fixture(autouse=True)
def style():
    apply_style()


def found():
    """Two splits of two simulators; one has both causes, the other none and no errors."""
    return [
        diagnosed(verdict(causes=(WIND, GRAVITY, CAMERA, MINOR)), "first_one", 0),
        diagnosed(verdict(), "first_one", 1),
        diagnosed(verdict("no_gap", (), gap=None), "other", 0),
    ]


def test_errors_have_a_panel_a_simulator_and_a_line_a_split():
    figure = closing_figure(found()).figure
    first, other = figure.axes
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["first one", "other"]
    assert len(first.lines) == 2 * len(LINES) and not other.lines
    before = [line for line in first.lines if line.get_label() == LINE_NAMES["before"]]
    assert [line.get_ydata().tolist() for line in before] == [list(GAP.before_mm)] * 2
    shown = [text.get_text() for text in figure.legends[0].get_texts()]
    assert shown == list(LINE_NAMES.values())


def test_a_cause_without_a_minimum_detectable_effect_has_no_row():
    limits = {"gravity.g": 0.05}
    one = verdict(causes=(WIND, GRAVITY)).model_copy(update={"minimum_detectable": limits})
    (axes,) = stability_figure([diagnosed(one, "first_one", 0)]).figure.axes
    assert [text.get_text() for text in axes.get_yticklabels()] == ["gravity.g"]


def test_causes_are_drawn_in_minimum_detectable_effects():
    figure = stability_figure(found()).figure
    first, other = figure.axes
    assert [text.get_text() for text in first.get_yticklabels()] == ["wind.x", "gravity.g"]
    marks = [line for line in first.lines if line.get_marker() == "o"]
    size = verdict().minimum_detectable["wind.x"]
    places = [(mark.get_xdata()[0], mark.get_ydata()[0]) for mark in marks]
    np.testing.assert_allclose(
        [places[0], places[2]], [(0.61 / size, -0.125), (0.61 / size, 0.125)]
    )
    assert not [line for line in other.lines if line.get_marker() == "o"]
