"""Figures and tables of policies show the numbers they were given."""

from itertools import product

import numpy as np
import pandas as pd
import pytest

from experiments.report.policies import (
    POLICIES,
    mechanism_figure,
    readings_figure,
    spread_policies_figure,
)
from rallygap.pipeline.report.plots import physics_colour
from rallygap.pipeline.report.retrain_policy import retraining_figure
from rallygap.pipeline.report.shot_quality import HATCH, calibration_figure, medians_figure
from rallygap.pipeline.report.sim2real import (
    PAPER_ROW,
    paper_form_table,
    tolerance_figure,
    transfer_figure,
)
from rallygap.pipeline.report.sim2sim import PREDICTORS, PROTOCOLS, sim2sim_figure
from rallygap.pipeline.report.train_policy import GOALS, achieved_figure, learning_figure
from rallygap.pipeline.transfer.rates import rates
from tests.pipeline.played_trials import KEYS, everything, trials

SETS, HORIZONS = ["stroke_pro", "spindoe"], ["115-125", "170-180"]
OBSERVATIONS = ("intercept", "strict")


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


def test_retraining_has_a_bar_for_every_policy_and_predictor():
    pairs = [("original", "physics"), ("original", "oracle"), ("retrained", "amended")]
    keys = [("arena", horizons, *pair) for horizons in HORIZONS for pair in pairs]
    table = made_up(keys, "set horizons_ms policy predictor")
    figure = retraining_figure(table)
    widths = [bar.get_width() for axes in figure.axes for bar in axes.patches]
    np.testing.assert_allclose(widths, 100 * table["return_rate"])
    assert [text.get_text() for text in figure.axes[0].get_yticklabels()] == [
        "original policy, own simulator",
        "original policy, oracle",
        "retrained policy, own simulator amended",
    ]
    assert titles(figure)[1] == "arena, horizons 170–180 ms, 20 shots, 2 trainings"
    (alone, _) = titles(retraining_figure(table.assign(trainings=1)))
    assert alone == "arena, horizons 115–125 ms, 20 shots, 1 training"


def test_hits_and_returns_of_every_set_are_drawn_in_the_predictor_s_colour():
    pairs = [("physics", "first_window"), ("physics", "every_tick"), ("transformer", "every_tick")]
    keys = [(name, horizons, *pair) for name, horizons, pair in product(SETS, HORIZONS, pairs)]
    keys += [("stroke_pro", horizons, "oracle", "every_tick") for horizons in HORIZONS]
    table = made_up(keys, "set horizons_ms predictor protocol", hit_rate=0.95)
    figure = transfer_figure(table)
    assert "2 trainings per bar" in [one.get_title().get_text() for one in figure.legends]
    assert titles(figure) == ["horizons 115–125 ms", "horizons 170–180 ms"]
    for axes, (_, panel) in zip(figure.axes, table.groupby("horizons_ms"), strict=True):
        for name in ("transformer", "oracle"):
            rows = panel[panel["predictor"] == name]
            expected = 100 * np.concatenate([rows["hit_rate"], rows["return_rate"]])
            np.testing.assert_allclose(heights(axes, physics_colour(name)), expected)


def test_every_kind_of_error_has_a_panel_with_a_line_for_each_horizons():
    sizes = [("bias", 0.0), ("bias", 5.0), ("noise", 0.0), ("noise", 5.0), ("no_spin", 0.0)]
    keys = [(*size, horizons) for horizons, size in product(HORIZONS, sizes)]
    table = made_up(keys, "error size_cm horizons_ms")
    figure = tolerance_figure(table)
    assert figure.legends[0].get_title().get_text() == "20 shots, 2 trainings"
    for axes, error in zip(figure.axes, ("bias", "noise"), strict=True):
        drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
        for horizons, rows in table[table["error"] == error].groupby("horizons_ms"):
            expected = np.column_stack([rows["size_cm"], 100 * rows["return_rate"]])
            np.testing.assert_allclose(drawn[f"{horizons} ms"], expected)


def test_the_paper_s_numbers_stand_below_ours():
    table = paper_form_table(rates(everything(), KEYS), ["transformer"])
    ours, theirs = table.to_dict("records")
    assert (ours["learned_predictor"], theirs["learned_predictor"]) == ("transformer", PAPER_ROW)
    assert (ours["shots"], theirs["shots"]) == (4, 200)
    assert ours["115-125 ms: physics returns"] == 1.5
    assert ours["170-180 ms: learned returns"] == 2.5
    assert theirs["115-125 ms: physics hits"] == 136
    assert theirs["170-180 ms: learned returns"] == 92
    assert len(table.columns) == 3 + 8


def test_sets_and_horizons_that_the_paper_has_not_are_ours_alone():
    own = everything().assign(set="spindoe")
    other = trials([1, 0], horizons_ms="60-70")
    played = pd.concat([own, other, other.assign(predictor="transformer")], ignore_index=True)
    table = paper_form_table(rates(played, KEYS), ["transformer"])
    assert list(table["set"]) == ["spindoe", "stroke_pro", "stroke_pro"]
    assert table["60-70 ms: physics hits"].notna().tolist() == [False, True, False]


def sim2sim_rates(policies):
    keys = product(PROTOCOLS, ["imperfect_a", "imperfect_c"], HORIZONS, PREDICTORS)
    table = made_up(keys, "protocol simulator horizons_ms predictor")
    table.columns = [name.replace("return_rate_", "ci_") for name in table]
    each = [[share + 0.01 * k for k in range(policies)] for share in table["return_rate"]]
    return table.assign(per_seed=each, trainings=policies)


def test_every_protocol_has_bars_with_intervals_for_every_simulator_and_horizons():
    table = sim2sim_rates(policies=2)
    figure = sim2sim_figure(table)
    assert titles(figure) == list(PROTOCOLS.values())
    for axes, (_, panel) in zip(figure.axes, table.groupby("protocol"), strict=True):
        own = [panel[panel["predictor"] == name] for name in PREDICTORS]
        for (_, colour, _), rows in zip(PREDICTORS.values(), own, strict=True):
            np.testing.assert_allclose(heights(axes, colour), 100 * rows["return_rate"])
        ends = [path.vertices[:, 1] for lines in axes.collections for path in lines.get_paths()]
        np.testing.assert_allclose(ends, 100 * pd.concat(own)[["ci_low", "ci_high"]])


@pytest.mark.parametrize(
    ("policies", "words"),
    [(1, ["20 shots, 1 training"]), (2, ["20 shots, 2 trainings", "single policy"])],
)
def test_the_legend_says_how_many_shots_and_trainings_a_rate_is_of(policies, words):
    (legend,) = sim2sim_figure(sim2sim_rates(policies)).legends
    texts = [text.get_text().removeprefix("95 % interval, ") for text in legend.get_texts()]
    assert texts[2:] == words


QUALITY = [
    {"set": name, "horizons_ms": horizons, "predictor": predictor, "speed": height,
     "speed_low": height - 1, "speed_high": height + 2}
    for name, height in (("stroke_pro", 5.0), ("receive", 6.0))
    for horizons in HORIZONS
    for predictor in ("transformer", "physics")
]  # fmt: skip


def test_a_bar_is_a_median_and_the_shorter_horizons_are_hatched():
    (axes,) = medians_figure(pd.DataFrame(QUALITY), {"speed": "ball speed"}).axes
    bars = sorted(axes.patches, key=lambda bar: bar.get_x())
    assert [bar.get_height() for bar in bars] == [5.0] * 4 + [6.0] * 4
    assert [bar.get_hatch() for bar in bars] == [HATCH, ""] * 4
    assert len({bar.get_facecolor() for bar in bars[:4]}) == 2
    assert bars[0].get_facecolor() == bars[1].get_facecolor()
    assert axes.get_title(loc="left") == "ball speed"


def test_without_returns_there_is_no_bar():
    rows = [dict(QUALITY[0], speed=float("nan")), *QUALITY[1:]]
    figure = medians_figure(pd.DataFrame(rows), {"speed": "ball speed"})
    assert len(figure.axes[0].patches) == len(rows) - 1


def test_the_calibration_curve_is_the_table_s():
    table = pd.DataFrame({"method": ["forest"] * 2, "probability": [0.1, 0.4], "share": [0.2, 0.3]})
    (axes,) = calibration_figure(table, 0.25).axes
    drawn = next(line for line in axes.lines if line.get_label() == "forest")
    assert drawn.get_xydata() == pytest.approx(table[["probability", "share"]].to_numpy())


def test_every_policy_is_a_line_in_the_row_of_its_group():
    names = ["group", "simulator", "horizons_ms", "repeat"]
    policies = [
        ("sim2sim", "imperfect_a", "115-125", 0),
        ("sim2sim", "imperfect_a", "170-180", 0),
        ("sim2sim", "imperfect_c", "115-125", 0),
        ("sim2sim", "imperfect_c", "115-125", 1),
        ("strict_inputs", "imperfect_c", "170-180", 0),
    ]
    table = made_up([policy for policy in policies for _ in range(3)], " ".join(names))
    table = table.assign(hit_rate=0.5 * table["return_rate"])
    curves = table.assign(control_steps=[16_000, 32_000, 48_000] * len(policies))
    figure = learning_figure(curves)
    assert [title for title in titles(figure) if title] == ["sim2sim", "strict inputs"]
    for column, rate in enumerate(("return_rate", "hit_rate")):
        panels = figure.axes[column::2]
        assert [len(axes.lines) for axes in panels] == [4, 1]
        lines = [line for axes in panels for line in axes.lines]
        for line, (_, rows) in zip(lines, curves.groupby(names, sort=False), strict=True):
            expected = np.column_stack([rows["control_steps"] / 1000, 100 * rows[rate]])
            np.testing.assert_allclose(line.get_xydata(), expected)


def achieved(*goals):
    """Returns that achieve 1 + half of what was asked, here and there a little more or less."""
    columns = {}
    for number, name in enumerate(goals):
        columns[f"goal_{name}"] = goal = np.linspace(number, number + 3, 4)
        columns[name] = 1 + 0.5 * goal + [0.1, -0.1, -0.1, 0.1]
    return pd.DataFrame(columns)


def test_every_goal_has_a_panel_with_its_returns_and_their_line():
    balls = achieved(*GOALS)

    figure = achieved_figure(balls)

    assert titles(figure) == ["slope 0.50"] * len(GOALS)
    for axes, name in zip(figure.axes, GOALS, strict=True):
        dots, perfect, fitted = axes.lines
        np.testing.assert_array_equal(dots.get_xydata(), balls[[f"goal_{name}", name]])
        np.testing.assert_array_equal(perfect.get_xdata(), perfect.get_ydata())
        np.testing.assert_allclose(fitted.get_ydata(), 1 + 0.5 * fitted.get_xdata())
        assert axes.get_xlabel() == f"goal: {GOALS[name]}"


def test_without_returns_there_is_no_line_and_the_panel_says_so():
    figure = achieved_figure(achieved("speed")[:0])

    assert len(figure.axes[0].lines) == 1
    assert titles(figure) == ["too few returns for a slope"]


def test_every_rate_of_policies_with_spreads_is_drawn():
    keys = product(("games", "launches"), ("physics", "oracle", "transformer"), POLICIES)
    table = made_up(keys, "set predictor policy")
    table = table.query("set != 'launches' or predictor != 'oracle'")
    for axes, predictors in zip(spread_policies_figure(table).axes, (3, 2), strict=True):
        drawn = [len(marks.lines[0].get_xdata()) for marks in axes.containers]
        assert drawn == [predictors] * len(POLICIES)


def test_every_rate_is_drawn_under_both_readings():
    predictors = ("physics_c", "amended", "oracle", "hybrid", "tae")
    keys = product(OBSERVATIONS, HORIZONS, predictors, ("first_window", "every_tick"))
    figure = readings_figure(made_up(keys, "observation horizons_ms predictor protocol"))
    assert [len(axes.containers) for axes in figure.axes] == [2 * len(predictors)] * 4


def test_the_gain_of_every_setting_is_written():
    ages = ("40", "80", "160", "320", "first window")
    predictors = ("amended", "oracle")
    keys = product(OBSERVATIONS, HORIZONS, ages, (0, 40, 100, 200), (0.0, 0.2), predictors)
    names = ["observation", "horizons_ms", "every_ms", "latency_ms", "label_error", "predictor"]
    rows = pd.DataFrame(keys, columns=names).assign(outcome="returns", difference=0.1, p_holm=0.01)
    rows.loc[rows["every_ms"] == "320", "difference"] = -0.2
    panels = mechanism_figure(rows).axes[: len(predictors) * 4]
    assert {axes.images[0].get_clim() for axes in panels} == {(-20, 20)}
    for axes in panels:
        assert sorted(text.get_text() for text in axes.texts) == ["+10"] * 16 + ["-20"] * 4
