"""The figures of a verdict show the numbers they were given."""

import numpy as np
import pytest

from pipeline.gap.figures.verdict import KIND_COLOURS, causes_figure, error_figure
from tests.pipeline.verdicts import GAP, GRAVITY, WIND, verdict


def test_causes_stand_at_their_departure_in_detectable_sizes():
    axes = causes_figure(verdict("ambiguous", (WIND, GRAVITY))).axes[0]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["wind.x", "gravity"]
    drawn = {
        line.get_color(): line.get_xdata() for line in axes.lines if len(line.get_xdata()) == 1
    }
    assert drawn[KIND_COLOURS["missing_effect"]] == pytest.approx([0.61 / (2.959 * 0.02)], rel=1e-3)
    assert drawn[KIND_COLOURS["wrong_value"]] == pytest.approx([0.49 / (2.959 * 0.1)], rel=1e-3)


def test_intervals_of_causes_are_drawn():
    axes = causes_figure(verdict()).axes[0]
    intervals = [line.get_xdata() for line in axes.lines if line.get_linewidth() == 3]
    np.testing.assert_allclose(intervals, [[0.59 / 0.0592, 0.63 / 0.0592]], rtol=1e-3)


def test_without_causes_there_is_nothing_to_draw():
    with pytest.raises(ValueError, match="without causes"):
        causes_figure(verdict("no_gap", ()))


def test_errors_are_drawn_over_the_horizon():
    axes = error_figure(GAP).axes[0]
    for line, values in zip(axes.lines, (GAP.before_mm, GAP.after_mm, GAP.floor_mm), strict=True):
        np.testing.assert_array_equal(line.get_xydata(), np.column_stack([GAP.horizons_ms, values]))
    within = (GAP.before_interval_mm, GAP.after_interval_mm)
    for band, intervals in zip(axes.collections, within, strict=True):
        (low, high) = np.array(intervals)[-1]
        ends = {y for x, y in band.get_paths()[0].vertices if x == GAP.horizons_ms[-1]}
        assert ends == {low, high}
