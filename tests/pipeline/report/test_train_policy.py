"""The figures of learning show the numbers they were given."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.report.train_policy import GOALS, achieved_figure, learning_figure
from rallygap.pipeline.web.figure_style import apply_style

TICKS = np.array([16_000, 32_000, 48_000])


@pytest.fixture(autouse=True)
def style():
    apply_style()


def curve(group, simulator, horizons, repeat, start):
    rates = start + np.array([0.0, 0.2, 0.3])
    labels = {"group": group, "simulator": simulator, "horizons_ms": horizons, "repeat": repeat}
    return pd.DataFrame(
        {"control_steps": TICKS, "return_rate": rates, "hit_rate": rates + 0.1, **labels}
    )


CURVES = pd.concat(
    [
        curve("sim2sim", "imperfect_a", "115-125", 0, 0.1),
        curve("sim2sim", "imperfect_a", "170-180", 0, 0.2),
        curve("sim2sim", "imperfect_c", "115-125", 0, 0.3),
        curve("sim2sim", "imperfect_c", "115-125", 1, 0.4),
        curve("strict_inputs", "imperfect_c", "170-180", 0, 0.5),
    ]
)


@pytest.mark.parametrize(("column", "rate"), enumerate(["return_rate", "hit_rate"]))
def test_every_policy_is_a_line_in_the_row_of_its_group(column, rate):
    axes = np.reshape(learning_figure(CURVES).axes, (2, 2))[:, column]

    assert [len(panel.lines) for panel in axes] == [4, 1]
    lines = [line for panel in axes for line in panel.lines]
    for line, (_, rows) in zip(lines, CURVES.groupby(np.arange(15) // 3), strict=True):
        np.testing.assert_allclose(line.get_xdata(), rows["control_steps"] / 1000)
        np.testing.assert_allclose(line.get_ydata(), 100 * rows[rate])
    titles = [panel.get_title(loc="left") for panel in learning_figure(CURVES).axes]
    assert [title for title in titles if title] == ["sim2sim", "strict inputs"]


def returns(*asked):
    """Returns that achieve 1 + half of what was asked, here and there a little more or less."""
    columns = {}
    for number, name in enumerate(asked):
        goal = np.linspace(number, number + 3, 4)
        columns[f"goal_{name}"] = goal
        columns[name] = 1 + 0.5 * goal + [0.1, -0.1, -0.1, 0.1]
    return pd.DataFrame(columns)


def test_every_goal_has_a_panel_with_its_returns_and_their_line():
    balls = returns(*GOALS)

    figure = achieved_figure(balls)

    assert len(figure.axes) == len(GOALS) == 4
    for panel, name in zip(figure.axes, GOALS, strict=True):
        dots, perfect, fitted = panel.lines
        np.testing.assert_array_equal(dots.get_xdata(), balls[f"goal_{name}"])
        np.testing.assert_array_equal(dots.get_ydata(), balls[name])
        np.testing.assert_array_equal(perfect.get_xdata(), perfect.get_ydata())
        np.testing.assert_allclose(fitted.get_ydata(), 1 + 0.5 * fitted.get_xdata())
        assert panel.get_title(loc="left") == "slope 0.50"
        assert panel.get_xlabel() == f"goal: {GOALS[name]}"


def test_without_returns_there_is_no_line_and_the_panel_says_so():
    (panel,) = achieved_figure(returns("speed")[:0]).axes

    assert len(panel.lines) == 1
    assert panel.get_title(loc="left") == "too few returns for a slope"
