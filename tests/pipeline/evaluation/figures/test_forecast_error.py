"""The figure of forecast errors shows the numbers it was given."""

import numpy as np
import pandas as pd
import pytest

from pipeline.evaluation.figures.forecast_error import forecast_error_figure, line_style
from pipeline.io.figure_style import predictor_colour
from tests.pipeline.web.example_reports import HORIZONS, forecast_errors


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


def test_what_was_fine_tuned_or_amended_is_told_by_its_dashes():
    colour, dashes = line_style("transformer")
    assert dashes == "solid"
    assert line_style("transformer_fine_tuned") == (colour, "dashed")
    assert line_style("amended_imperfect_c")[1] == "dotted"


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


def test_means_are_comparable_down_a_column_and_the_spread_has_its_own_scale():
    axes = forecast_error_figure(forecast_errors()).axes

    assert axes[0].get_ylim() == axes[6].get_ylim() == axes[9].get_ylim()
    assert axes[0].get_ylim()[0] == axes[3].get_ylim()[0] == 0
    assert axes[3].get_ylim()[1] < axes[0].get_ylim()[1]


def test_a_quantity_never_measured_in_some_windows_leaves_their_panel_empty():
    frame = forecast_errors().query("quantity != 'spin' or bounce != 'with'")

    axes = forecast_error_figure(frame).axes[8]  # spin, with a bounce

    assert [text.get_text() for text in axes.texts] == ["n = 0"]


def test_the_legend_lists_physics_before_trained_predictors():
    made_up = forecast_errors(["position"], ["all"])
    trained = made_up.replace({"predictor": {"physics_c": "gru_tae"}})

    figure = forecast_error_figure(pd.concat([trained, made_up]))

    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["physics_c", "physics_literature", "gru_tae"]


def test_two_sets_in_one_figure_are_refused():
    two = pd.concat([forecast_errors(), forecast_errors().assign(set="tt3d")])

    with pytest.raises(ValueError, match=r"one set, but the frame holds \['spindoe', 'tt3d'\]"):
        forecast_error_figure(two)
