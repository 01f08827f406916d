"""The report of `train_policy`: learning curves, a return, achieved goals, test scores."""

from collections.abc import Iterator
from itertools import cycle
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rallygap.models.policy.scores import fitted_line
from rallygap.models.robot.view import frames
from rallygap.pipeline.io.artifacts import read_table
from rallygap.pipeline.policies.training import RETURN, TEST_TRIALS, VALIDATION_SHOTS
from rallygap.pipeline.report.plots import ahead
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, MUTED
from rallygap.pipeline.web.labels import simulator_label
from rallygap.pipeline.web.report_items import (
    ReportAnimation,
    ReportFigure,
    ReportItem,
    ReportTable,
)

POLICY = ["simulator", "horizons_ms", "repeat"]
RATES = {"return_rate": "returned (%)", "hit_rate": "hit (%)"}
GOALS = {
    "landing_across": "landing across (m)",
    "landing_along": "landing behind the net (m)",
    "speed": "speed (m/s)",
    "topspin": "topspin (rad/s)",
}
# Distinguishable with common colour blindness (Okabe and Ito 2008, Tol 2021).
COLOURS = ("#0f7fc4", "#d55e00", "#009988", "#b85fa0", "#a08000", "#7d8791")
DASHES = ("-", "--", ":", "-.")


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield learning curves, the animation of a shot, figures of goals, and the table."""
    yield ReportFigure(
        learning_figure(run.kept("train_policy", "learning")),
        "learning",
        title="Learning curves of the policies",
        caption=f"After each training iteration a policy plays {VALIDATION_SHOTS} validation shots "
        "of its own simulator, without exploration noise. A control step is one action of one "
        "environment.",
    )
    with np.load(run.input("train_policy", RETURN)) as motion:
        yield ReportAnimation(
            frames(motion["joints"], motion["ball"]),
            "return",
            title="A return" if motion["returned"] else "A miss",
            caption=f"The policy {motion['policy']} plays a test shot, at half speed. Bullet "
            "simulates the arm, the ball simulator the ball.",
        )
    yield from _goal_figures(run)
    yield ReportTable(
        run.kept("train_policy", "policies"),
        "policies",
        title="Trained policies",
        caption=f"Each policy plays {run.params.train_policy.trials} test shots of its own "
        "simulator with exact forecasts. A return lands on the far half; landing_error_m is the "
        "mean distance of returns from their goals. Slopes: of the speed and the topspin of "
        "returns over their goals, where there are such goals; 1 is perfect.",
    )


def _goal_figures(run: StageRun) -> Iterator[ReportFigure]:
    """Yield a figure for each group with goals of speed or topspin."""
    trials = read_table(run.input("train_policy", TEST_TRIALS))
    for name, group in run.params.train_policy.groups.items():
        if group.goals.speed is None and group.goals.topspin is None:
            continue
        own = trials[trials["group"] == name]
        goals = own.filter(like="goal_")
        own = own.drop(columns=goals.columns[goals.isna().all()])
        yield ReportFigure(
            achieved_figure(own[own["returned"]]),
            f"achieved_{name}",
            title=f"Achieved values over goals: {name.replace('_', ' ')}",
            caption="Returns of test shots by all policies of the group: one dot per return, the "
            "least-squares line (solid) and the ideal (dashed).",
        )


def learning_figure(curves: pd.DataFrame) -> Figure:
    """Draw return and hit rates in training: a row of panels per group, a line per policy.

    Simulators differ by colour, horizons by dashes; repeats look alike.

    Args:
        curves: one row per iteration of a policy: group, simulator, horizons_ms, repeat,
            control_steps, return_rate and hit_rate (shares).
    """
    groups = list(curves["group"].unique())
    colours = dict(zip(curves["simulator"].unique(), cycle(COLOURS), strict=False))
    dashes = dict(zip(curves["horizons_ms"].unique(), cycle(DASHES), strict=False))
    figure = Figure(figsize=(FIGURE_WIDTH, 1.0 + 2.3 * len(groups)))
    grid = figure.subplots(len(groups), len(RATES), squeeze=False, sharey=True)
    for panels, group in zip(grid, groups, strict=True):
        policies = curves[curves["group"] == group].groupby(POLICY, sort=False)
        for axes, (rate, label) in zip(panels, RATES.items(), strict=True):
            for (simulator, horizons, _), curve in policies:
                style: dict[str, Any] = {"color": colours[simulator], "ls": dashes[horizons]}
                axes.plot(curve["control_steps"] / 1000, 100 * curve[rate], lw=1.4, **style)
            axes.set(xlabel="control steps (thousands)", ylabel=label, ylim=(0, 102))
            axes.set_xlim(left=0)
        panels[0].set_title(str(group).replace("_", " "))
    of_simulators = [
        Line2D([], [], color=colour, label=simulator_label(name))
        for name, colour in colours.items()
    ]
    of_horizons = [
        Line2D([], [], color=MUTED, ls=dash, label=f"horizons {ahead(name)}")
        for name, dash in dashes.items()
    ]
    figure.legend(handles=[*of_simulators, *of_horizons], loc="outside upper left", ncols=3)
    return figure


def achieved_figure(returns: pd.DataFrame) -> Figure:
    """Draw achieved values over goals, a panel per kind of goal.

    Args:
        returns: one row per return, columns of a ``TrialResult``.
    """
    goals = [name for name in GOALS if f"goal_{name}" in returns]
    rows = (len(goals) + 1) // 2
    figure = Figure(figsize=(FIGURE_WIDTH, 3.2 * rows))
    for place, name in enumerate(goals, start=1):
        axes = figure.add_subplot(rows, 2, place)
        _draw_achieved(axes, returns[f"goal_{name}"].to_numpy(), returns[name].to_numpy())
        axes.set(xlabel=f"goal: {GOALS[name]}", ylabel="achieved")
    return figure


def _draw_achieved(axes: Axes, goals: np.ndarray, achieved: np.ndarray) -> None:
    axes.plot(goals, achieved, ".", ms=3, color=COLOURS[0], alpha=0.4, mew=0)
    slope, intercept = fitted_line(goals, achieved)
    if np.isnan(slope):
        axes.set_title("too few returns for a slope")
        return
    ends = np.array([goals.min(), goals.max()])
    axes.plot(ends, ends, color=MUTED, lw=1.0, ls="--")
    axes.plot(ends, slope * ends + intercept, color=COLOURS[1])
    axes.set_title(f"slope {slope:.2f}")
