"""The figure of forecast errors shows the numbers it was given."""

import io

import numpy as np
import pandas as pd
import pytest

from pipeline.figures.forecast_error import forecast_error_figure
from pipeline.figures.style import apply_style, predictor_colour
from tests.pipeline.figures.made_up import HORIZONS, forecast_errors


def png(frame):
    buffer = io.BytesIO()
    forecast_error_figure(frame).savefig(buffer, metadata={"Software": None})
    return buffer.getvalue()


def test_lines_are_mean_and_standard_deviation():
    frame = forecast_errors()
    panel = forecast_error_figure(frame).axes[3]  # second row: with a bounce, position

    drawn = [line.get_ydata() for line in panel.lines if line.get_color() == "#0f7fc4"]

    rows = frame.query("predictor == 'physics_c' and quantity == 'position' and bounce == 'with'")
    np.testing.assert_array_equal(drawn, [rows["mean"], rows["std"]])
    assert predictor_colour("physics_c") == "#0f7fc4"
    assert list(panel.lines[0].get_xdata()) == list(HORIZONS)


def test_band_is_the_interval():
    frame = forecast_errors(quantities=["position"], windows=["all"])
    panel = forecast_error_figure(frame).axes[0]

    last = frame.query("predictor == 'physics_c' and horizon_ms == 300").iloc[0]
    corners = panel.collections[0].get_paths()[0].vertices
    heights = corners[corners[:, 0] == 300, 1]
    assert (heights.min(), heights.max()) == pytest.approx((last["ci_low"], last["ci_high"]))


def test_order_of_rows_does_not_matter():
    apply_style()
    frame = forecast_errors()

    assert png(frame) == png(frame.sample(frac=1, random_state=0))


@pytest.mark.parametrize(
    ("quantities", "windows", "panels"),
    [
        (["position", "velocity", "spin"], ["all", "with", "without"], 9),
        (["position", "velocity"], ["all", "without"], 4),
    ],
)
def test_what_a_set_has_not_gets_no_panel(quantities, windows, panels):
    figure = forecast_error_figure(forecast_errors(quantities, windows))

    assert len(figure.axes) == panels
    assert all(axes.lines for axes in figure.axes)


def test_errors_of_windows_are_comparable_down_a_column():
    axes = forecast_error_figure(forecast_errors()).axes

    assert axes[0].get_ylim() == axes[3].get_ylim() == axes[6].get_ylim()
    assert axes[0].get_ylim()[0] == 0


def test_two_sets_in_one_figure_are_refused():
    two = pd.concat([forecast_errors(), forecast_errors().assign(set="tt3d")])

    with pytest.raises(ValueError, match=r"one set, but the frame holds \['spindoe', 'tt3d'\]"):
        forecast_error_figure(two)
