"""The figure of forecast errors shows the numbers it was given."""

import numpy as np
import pytest

from rallygap.pipeline.report.forecast_error import forecast_error_figure
from rallygap.pipeline.web.figure_style import predictor_colour
from tests.pipeline.report.example_reports import HORIZONS, forecast_errors


@pytest.mark.parametrize(
    ("panel", "window", "number"),
    [(0, "all", "mean"), (3, "all", "std"), (6, "with", "mean"), (9, "without", "mean")],
)
def test_lines_are_the_numbers_of_the_row(panel, window, number):
    frame = forecast_errors()
    axes = forecast_error_figure(frame).axes[panel]  # of the first quantity, position

    drawn = [line.get_ydata() for line in axes.lines if line.get_color() == "#0f7fc4"]

    rows = frame.query("predictor == 'physics_c' and quantity == 'position' and bounce == @window")
    np.testing.assert_array_equal(drawn, [rows[number]])
    assert predictor_colour("physics_c") == "#0f7fc4"
    assert list(axes.lines[0].get_xdata()) == list(HORIZONS)


def test_band_is_the_interval():
    frame = forecast_errors(quantities=["position"], windows=["all"])
    panel = forecast_error_figure(frame).axes[0]

    last = frame.query("predictor == 'physics_c' and horizon_ms == 300").iloc[0]
    corners = panel.collections[0].get_paths()[0].vertices
    heights = corners[corners[:, 0] == 300, 1]
    assert (heights.min(), heights.max()) == pytest.approx((last["ci_low"], last["ci_high"]))


@pytest.mark.parametrize(
    ("quantities", "windows", "panels"),
    [
        (["position", "velocity", "spin"], ["all", "with", "without"], 12),
        (["position", "velocity"], ["all", "without"], 6),
    ],
)
def test_what_a_set_has_not_gets_no_panel(quantities, windows, panels):
    figure = forecast_error_figure(forecast_errors(quantities, windows))

    assert len(figure.axes) == panels
    assert all(axes.lines for axes in figure.axes)


def test_a_quantity_never_measured_in_some_windows_leaves_their_panel_empty():
    frame = forecast_errors().query("quantity != 'spin' or bounce != 'with'")

    axes = forecast_error_figure(frame).axes[8]  # spin, with a bounce

    assert [text.get_text() for text in axes.texts] == ["n = 0"]
