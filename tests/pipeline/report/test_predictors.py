"""Figures of predictors: their errors and the coverage of their regions."""

from itertools import product

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.report.evaluate_predictor import coverage_figure, forecast_error_figure
from tests.pipeline.report.example_reports import HORIZONS, forecast_errors


def test_lines_are_the_numbers_of_their_row_and_the_band_is_the_interval():
    frame = forecast_errors()
    panels = forecast_error_figure(frame).axes[::3]  # of the first quantity, position
    rows_of = frame.query("predictor == 'physics_c' and quantity == 'position'").groupby("bounce")
    statistics = [("all", "mean"), ("all", "std"), ("with", "mean"), ("without", "mean")]
    for axes, (window, number) in zip(panels, statistics, strict=True):
        drawn = [line.get_ydata() for line in axes.lines if line.get_color() == "#0f7fc4"]
        np.testing.assert_array_equal(drawn, [rows_of.get_group(window)[number]])
        assert list(axes.lines[0].get_xdata()) == list(HORIZONS)
    corners = panels[0].collections[0].get_paths()[0].vertices
    heights = corners[corners[:, 0] == 300, 1]
    last = rows_of.get_group("all").iloc[-1]
    assert (heights.min(), heights.max()) == pytest.approx((last["ci_low"], last["ci_high"]))


def test_what_a_set_has_not_gets_no_panel_and_what_some_windows_have_not_an_empty_one():
    frame = forecast_errors()
    some = frame.query("quantity != 'spin' and bounce != 'with'")
    assert [len(axes.lines) > 0 for axes in forecast_error_figure(some).axes] == [True] * 6
    fewer = frame.query("quantity != 'spin' or bounce != 'with'")
    panel = forecast_error_figure(fewer).axes[8]  # spin, with a bounce
    assert [text.get_text() for text in panel.texts] == ["n = 0"]


@pytest.mark.parametrize("drawn", [["transformer", "physics_c"], ["tae", "gru_tae"]])
def test_coverage_and_size_are_of_the_main_predictors_where_a_set_has_them(drawn):
    keys = product(sorted({*drawn, "tae"}), (0.5, 0.9), (100, 125, 130, 150))
    rows = pd.DataFrame(keys, columns=["predictor", "level", "horizon_ms"])
    rows["coverage"], rows["size_mm"] = np.linspace(0.4, 0.9, len(rows)), 20.0 + rows.index
    panels = coverage_figure(rows).axes
    for level, above, below in zip((0.5, 0.9), panels[:2], panels[2:], strict=True):
        own = rows[(rows["level"] == level) & (rows["horizon_ms"] != 130)]
        for axes, column, unit in ((above, "coverage", 100), (below, "size_mm", 1)):
            lines = [line.get_ydata().tolist() for line in axes.lines if len(line.get_xdata()) == 3]
            expected = [unit * own[own["predictor"] == name][column] for name in drawn]
            assert sorted(lines) == sorted(one.tolist() for one in expected)
