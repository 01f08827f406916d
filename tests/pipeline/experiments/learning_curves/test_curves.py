"""Learning curves of known errors."""

import numpy as np
import pytest

from rallygap.pipeline.experiments.learning_curves.curves import Errors, curve_rows
from rallygap.pipeline.report.forecast_experiments import learning_curves_figure

TESTED = np.repeat(np.arange(30), 4)


def errors(predictor, recordings, size, spread=0.0, seed=0, draws=3):
    """Errors in m at two horizons, of which the second is twice the first."""
    random = np.random.default_rng(seed)
    of_windows = size * (1 + spread * random.standard_normal((draws, len(TESTED), 1)))
    return Errors(predictor, recordings, of_windows * [1.0, 2.0])


def test_errors_are_means_over_draws_in_mm_and_in_those_of_the_oracle():
    rows = curve_rows(
        [errors("oracle", 10, 0.02), errors("hybrid", 10, 0.03)], TESTED, [100, 200]
    ).set_index(["predictor", "horizon_ms"])
    hybrid = rows.loc["hybrid"]
    assert hybrid["mean"].tolist() == pytest.approx([30.0, 60.0])
    assert hybrid["median"].tolist() == pytest.approx([30.0, 60.0])
    assert hybrid["of_oracle"].tolist() == pytest.approx([1.5, 1.5])
    assert hybrid["ci_low"].tolist() == pytest.approx(hybrid["ci_high"].tolist())
    assert hybrid["n"].tolist() == [120, 120]


def test_intervals_have_the_spread_of_windows_and_of_draws():
    same = errors("oracle", 10, 0.02, spread=0.3, draws=1)
    draws = Errors("hybrid", 10, same.by_draw * np.array([0.5, 1.0, 1.5])[:, None, None])
    rows = curve_rows([same, draws], TESTED, [100, 200]).set_index(["predictor", "horizon_ms"])
    width = (rows["ci_high"] - rows["ci_low"]).xs(100, level=1)
    assert width["oracle"] == pytest.approx(2 * 1.96 * 20 * 0.3 / np.sqrt(120), rel=0.3)
    # Three draws that differ by half; t has two degrees of freedom.
    assert width["hybrid"] == pytest.approx(2 * 4.30 * 20 * 0.5 / np.sqrt(3), rel=0.1)


def test_windows_without_a_measurement_do_not_count():
    some = errors("oracle", 10, 0.02)
    some.by_draw[:, 0, 1] = np.nan
    rows = curve_rows([some], TESTED, [100, 200])
    assert rows["n"].tolist() == [120, 119]
    assert rows["mean"].tolist() == pytest.approx([20.0, 40.0])


def test_the_figure_has_a_panel_a_horizon_and_a_line_a_predictor():
    made = [errors(name, size, 0.02) for name in ("oracle", "hybrid") for size in (10, 30)]
    figure = learning_curves_figure(curve_rows(made, TESTED, [100, 200]))
    titles = [axes.get_title() or axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["100 ms ahead", "200 ms ahead"]
    (line,) = (one for one in figure.axes[1].lines if one.get_label().startswith("oracle"))
    assert line.get_xdata().tolist() == [10, 30]
    assert line.get_ydata().tolist() == pytest.approx([40.0, 40.0])
