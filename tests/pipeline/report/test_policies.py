"""Figures and tables of policies and predictors show the numbers they were given."""

from itertools import product

import numpy as np
import pandas as pd
import pytest

from experiments.report.policies import mechanism_figure
from rallygap.pipeline.report.evaluate_predictor import coverage_figure, forecast_error_figure
from rallygap.pipeline.report.plots import physics_colour
from rallygap.pipeline.report.shot_quality import HATCH, medians_figure
from rallygap.pipeline.report.sim2real import PAPER_ROW, paper_form_table, transfer_figure
from rallygap.pipeline.report.sim2sim import PREDICTORS, PROTOCOLS, sim2sim_figure
from rallygap.pipeline.report.train_policy import GOALS, achieved_figure
from rallygap.pipeline.transfer.rates import rates
from tests.pipeline.played_trials import KEYS, everything, trials
from tests.pipeline.report.example_reports import forecast_errors

SETS, HORIZONS = ["stroke_pro", "spindoe"], ["115-125", "170-180"]


def made_up(keys, columns, **constants):
    """A row for each key, with return rates of which no two are alike."""
    rows = pd.DataFrame(list(keys), columns=columns.split()).assign(balls=20, trainings=2)
    rate = 0.9 - 0.5 / len(rows) * np.arange(len(rows))
    ends = {"return_rate_low": rate - 0.05, "return_rate_high": rate + 0.04}
    return rows.assign(return_rate=rate, **ends, **constants)


def heights(axes, colour):
    """Heights of the bars of a colour."""
    code = [tuple(round(255 * part) for part in bar.get_facecolor()[:3]) for bar in axes.patches]
    wanted = tuple(bytes.fromhex(colour[1:]))
    return [bar.get_height() for bar, own in zip(axes.patches, code, strict=True) if own == wanted]


def titles(figure):
    return [axes.get_title(loc="left") for axes in figure.axes]


def test_hits_and_returns_of_every_set_are_drawn_in_the_predictor_s_colour():
    pairs = [("physics", "first_window"), ("physics", "every_tick"), ("transformer", "every_tick")]
    keys = [(name, horizons, *pair) for name, horizons, pair in product(SETS, HORIZONS, pairs)]
    keys += [("stroke_pro", horizons, "oracle", "every_tick") for horizons in HORIZONS]
    table = made_up(keys, "set horizons_ms predictor protocol", hit_rate=0.95)
    figure = transfer_figure(table)
    for axes, (_, panel) in zip(figure.axes, table.groupby("horizons_ms"), strict=True):
        for name in ("transformer", "oracle"):
            rows = panel[panel["predictor"] == name]
            expected = 100 * np.concatenate([rows["hit_rate"], rows["return_rate"]])
            np.testing.assert_allclose(heights(axes, physics_colour(name)), expected)


def test_the_paper_s_numbers_stand_below_ours_on_its_sets_and_horizons():
    other = trials([1, 0], horizons_ms="60-70")
    unlike = [everything().assign(set="spindoe"), other, other.assign(predictor="transformer")]
    table = paper_form_table(rates(pd.concat([everything(), *unlike]), KEYS), ["transformer"])
    assert list(table["set"]) == ["stroke_pro", "stroke_pro", "spindoe"]
    ours, theirs, _ = table.to_dict("records")
    assert (ours["learned_predictor"], theirs["learned_predictor"]) == ("transformer", PAPER_ROW)
    assert (ours["shots"], theirs["shots"]) == (4, 200)
    assert ours["115-125 ms: physics returns"] == 1.5
    assert ours["170-180 ms: learned returns"] == 2.5
    assert theirs["115-125 ms: physics hits"] == 136
    assert theirs["170-180 ms: learned returns"] == 92
    assert table["60-70 ms: physics hits"].notna().tolist() == [True, False, False]


def test_every_protocol_has_bars_with_intervals_for_every_simulator_and_horizons():
    keys = product(PROTOCOLS, ["imperfect_a", "imperfect_c"], HORIZONS, PREDICTORS)
    table = made_up(keys, "protocol simulator horizons_ms predictor")
    table.columns = [name.replace("return_rate_", "ci_") for name in table]
    each = [[share, share + 0.01] for share in table["return_rate"]]
    figure = sim2sim_figure(table.assign(per_seed=each))
    for axes, (_, panel) in zip(figure.axes, table.groupby("protocol"), strict=True):
        own = [panel[panel["predictor"] == name] for name in PREDICTORS]
        for (_, colour, _), rows in zip(PREDICTORS.values(), own, strict=True):
            np.testing.assert_allclose(heights(axes, colour), 100 * rows["return_rate"])
        ends = [path.vertices[:, 1] for lines in axes.collections for path in lines.get_paths()]
        np.testing.assert_allclose(ends, 100 * pd.concat(own)[["ci_low", "ci_high"]])


def test_a_bar_is_a_median_and_the_shorter_horizons_are_hatched():
    keys = product(["stroke_pro", "receive"], ["physics", "transformer"], HORIZONS)
    table = pd.DataFrame(keys, columns=["set", "predictor", "horizons_ms"])
    speed = pd.Series([5.0, 5.1, 5.2, 5.3, 6.0, 6.1, 6.2, np.nan])  # nobody returned the last
    table = table.assign(speed=speed, speed_low=speed - 1, speed_high=speed + 2)
    (axes,) = medians_figure(table, {"speed": "ball speed"}).axes
    bars = sorted(axes.patches, key=lambda bar: bar.get_x())
    assert [bar.get_height() for bar in bars] == speed[:7].tolist()
    assert [bar.get_hatch() for bar in bars] == [HATCH, "", HATCH, "", HATCH, "", HATCH]
    for name, at in (("physics", [0, 1, 4, 5]), ("transformer", [2, 3, 6])):
        assert heights(axes, physics_colour(name)) == speed[at].tolist()


def test_every_goal_has_a_panel_with_its_returns_and_their_line_if_there_are_some():
    columns = {}
    for number, name in enumerate(GOALS):
        columns[f"goal_{name}"] = goal = np.linspace(number, number + 3, 4)
        columns[name] = 1 + 0.5 * goal + [0.1, -0.1, -0.1, 0.1]
    balls = pd.DataFrame(columns)
    figure = achieved_figure(balls)
    assert titles(figure) == ["slope 0.50"] * len(GOALS)
    for axes, name in zip(figure.axes, GOALS, strict=True):
        dots, perfect, fitted = axes.lines
        np.testing.assert_array_equal(dots.get_xydata(), balls[[f"goal_{name}", name]])
        np.testing.assert_array_equal(perfect.get_xdata(), perfect.get_ydata())
        np.testing.assert_allclose(fitted.get_ydata(), 1 + 0.5 * fitted.get_xdata())
    without = achieved_figure(balls[:0])
    assert [len(axes.lines) for axes in without.axes] == [1] * len(GOALS)
    assert set(titles(without)) == {"too few returns for a slope"}


def test_the_gain_of_every_setting_is_written():
    ages = ("40", "80", "160", "320", "first window")
    settings = product(("intercept", "strict"), ages, (0, 40, 100, 200), (0.0, 0.2))
    names = ["observation", "every_ms", "latency_ms", "label_error"]
    rows = pd.DataFrame(settings, columns=names).assign(outcome="returns", p_holm=0.01)
    rows = rows.assign(horizons_ms="115-125", predictor="amended", difference=0.1)
    rows.loc[rows["every_ms"] == "320", "difference"] = -0.2
    for axes in mechanism_figure(rows).axes[:4]:
        assert sorted(text.get_text() for text in axes.texts) == ["+10"] * 16 + ["-20"] * 4


def test_lines_are_the_numbers_of_their_row_and_the_band_is_the_interval():
    frame = forecast_errors()
    panels = forecast_error_figure(frame).axes[::3]  # of the first quantity, position
    rows_of = frame.query("predictor == 'physics_c' and quantity == 'position'").groupby("bounce")
    statistics = [("all", "mean"), ("all", "std"), ("with", "mean"), ("without", "mean")]
    for axes, (window, number) in zip(panels, statistics, strict=True):
        drawn = [line.get_ydata() for line in axes.lines if line.get_color() == "#0f7fc4"]
        np.testing.assert_array_equal(drawn, [rows_of.get_group(window)[number]])
        assert list(axes.lines[0].get_xdata()) == list(range(100, 301, 5))
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
