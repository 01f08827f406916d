"""The figures of shot quality draw what the tables say."""

import pandas as pd
import pytest

from rallygap.pipeline.report.shot_quality import HATCH, calibration_figure, medians_figure

ROWS = [
    {"set": name, "horizons_ms": ahead, "predictor": predictor, "speed": height,
     "speed_low": height - 1, "speed_high": height + 2}
    for name, height in (("stroke_pro", 5.0), ("receive", 6.0))
    for ahead in ("115-125", "170-180")
    for predictor in ("transformer", "physics")
]  # fmt: skip


def test_a_bar_is_a_median_and_the_shorter_horizons_are_hatched():
    figure = medians_figure(pd.DataFrame(ROWS), {"speed": "ball speed"})
    (axes,) = figure.axes
    bars = sorted(axes.patches, key=lambda bar: bar.get_x())
    assert [bar.get_height() for bar in bars] == [5.0] * 4 + [6.0] * 4
    assert [bar.get_hatch() for bar in bars] == [HATCH, ""] * 4
    assert len({bar.get_facecolor() for bar in bars[:4]}) == 2
    assert bars[0].get_facecolor() == bars[1].get_facecolor()
    assert "ball speed" in (axes.get_title(), axes.get_title(loc="left"))


def test_without_returns_there_is_no_bar():
    rows = [dict(ROWS[0], speed=float("nan")), *ROWS[1:]]
    figure = medians_figure(pd.DataFrame(rows), {"speed": "ball speed"})
    assert len(figure.axes[0].patches) == len(ROWS) - 1


def test_the_calibration_curve_is_the_table_s():
    table = pd.DataFrame({"method": ["forest"] * 2, "probability": [0.1, 0.4], "share": [0.2, 0.3]})
    (axes,) = calibration_figure(table, 0.25).axes
    drawn = next(line for line in axes.lines if line.get_label() == "forest")
    assert drawn.get_xydata() == pytest.approx(table[["probability", "share"]].to_numpy())
