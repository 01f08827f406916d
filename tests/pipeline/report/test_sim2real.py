"""The figures of sim-to-real show the numbers they were given."""

from itertools import product

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.report.sim2real import tolerance_figure, transfer_figure
from rallygap.pipeline.web.figure_style import apply_style, predictor_colour

FORECASTERS = [
    ("physics", "first_window"),
    ("physics", "every_tick"),
    ("transformer", "every_tick"),
]
SETS, HORIZONS = ["stroke_pro", "spindoe"], ["115-125", "170-180"]


@pytest.fixture(autouse=True)
def style():
    apply_style()


def made_up():
    """Rates of two sets, no two of them alike; the oracle knows the first set alone."""
    keys = [(name, h, *one) for name, h, one in product(SETS, HORIZONS, FORECASTERS)]
    keys += [("stroke_pro", h, "oracle", "every_tick") for h in HORIZONS]
    rows = pd.DataFrame(keys, columns=["set", "horizons_ms", "predictor", "protocol"])
    rate = 0.8 - 0.03 * np.arange(len(rows))
    ends = {"return_rate_low": rate - 0.05, "return_rate_high": rate + 0.04}
    return rows.assign(balls=20, trainings=2, hit_rate=rate + 0.1, return_rate=rate, **ends)


def bars(axes, colour):
    """Heights of the bars of a colour: all hits, then all returns."""
    found = [bar for bar in axes.patches if matches(bar.get_facecolor(), colour)]
    return [bar.get_height() for bar in found]


def matches(colour, code):
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour[:3]) == code


def test_hits_and_returns_of_every_set_are_drawn_in_the_predictor_s_colour():
    rates = made_up()
    figure = transfer_figure(rates)
    assert "2 trainings per bar" in [one.get_title().get_text() for one in figure.legends]
    panels = figure.axes
    assert [axes.get_title(loc="left") for axes in panels] == [
        f"horizons {horizons.replace('-', '–')} ms" for horizons in HORIZONS
    ]
    for axes, (_, panel) in zip(panels, rates.groupby("horizons_ms"), strict=True):
        for name in ("transformer", "oracle"):
            rows = panel[panel["predictor"] == name]
            expected = 100 * np.concatenate([rows["hit_rate"], rows["return_rate"]])
            np.testing.assert_allclose(bars(axes, predictor_colour(name)), expected)


def tolerated(horizons=HORIZONS):
    """Return rates that fall with the error."""
    sizes = [("bias", 0.0), ("bias", 5.0), ("noise", 0.0), ("noise", 5.0), ("no_spin", 0.0)]
    keys = [(*one, ahead) for ahead, one in product(horizons, sizes)]
    rows = pd.DataFrame(keys, columns=["error", "size_cm", "horizons_ms"])
    rate = 0.9 - 0.04 * np.arange(len(rows))
    ends = {"return_rate_low": rate - 0.05, "return_rate_high": rate + 0.05}
    return rows.assign(balls=20, trainings=2, return_rate=rate, **ends)


def test_every_kind_of_error_has_a_panel_with_a_line_for_each_horizons():
    rates = tolerated()
    figure = tolerance_figure(rates)
    assert figure.legends[0].get_title().get_text() == "20 shots, 2 trainings"
    for axes, error in zip(figure.axes, ("bias", "noise"), strict=True):
        drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
        for horizons, rows in rates[rates["error"] == error].groupby("horizons_ms"):
            expected = np.column_stack([rows["size_cm"], 100 * rows["return_rate"]])
            np.testing.assert_allclose(drawn[f"{horizons} ms"], expected)
