"""The report of `shot_quality`: medians of the returns, and how good the forest is."""

from collections.abc import Iterator
from itertools import product

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from rallygap.pipeline.report.plots import BARS, WHISKERS, physics_colour, set_label
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.shot_quality.returns import METRICS
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, MUTED, predictor_order
from rallygap.pipeline.web.labels import predictor_label
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

HATCH = "////"  # the shorter horizons, as in the paper
METHOD_COLOURS = {"logistic": "#d55e00", "forest": "#0f7fc4"}


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield medians of the returns, the forest's validation, and its sensitivity."""
    yield from _returns(run)
    yield from _validation(run)
    yield from _receivers(run)


def _returns(run: StageRun) -> Iterator[ReportItem]:
    quality = run.kept("shot_quality", "quality")
    caption = (
        "Medians over all successful returns of sim2real, with 95 % intervals bootstrapped over "
        "balls. Speed and spin rate are those just after the racket; clearance is the gap between "
        "ball and net. The winning probability is a random forest's estimate for a professional "
        "of the arena who plays such a shot. Predictors return different balls, so the medians "
        "are of different balls."
    )
    yield ReportFigure(
        medians_figure(quality[quality["protocol"] == "every_tick"], METRICS),
        "quality",
        title="Shot quality: medians of four metrics",
        caption=f"{caption} Hatched: the shorter horizons, as in the paper. All predictors "
        "forecast at every control step.",
    )
    yield ReportTable(
        quality,
        "quality",
        title="Shot quality",
        caption=f"{caption} returns: mean number over policies. out_of_range: share of the "
        "returns with at least one feature outside the range of the forest's training shots; a "
        "forest does not extrapolate.",
    )
    yield ReportTable(
        run.kept("shot_quality", "out_of_range"),
        "out_of_range",
        title="Returns outside the range of the training shots",
        caption="Share of the returns with a feature below the smallest or above the largest "
        "value among the training shots. A return may have an unusual combination of features "
        "and lie within all ranges.",
    )
    yield ReportTable(
        run.kept("shot_quality", "swap"),
        "swap",
        title="Shot quality: effect of the predictor swap",
        caption="The median of a predictor divided by that of physics at every control step: "
        "1 is no change. 95 % intervals are bootstrapped over balls, the same ones for both. "
        "Predictors return different balls, so a ratio compares sets of returns and not "
        "single balls.",
    )


def _validation(run: StageRun) -> Iterator[ReportItem]:
    shots = run.kept("shot_quality", "shots")
    calibration = run.kept("shot_quality", "calibration")
    caption = (
        f"{len(shots)} good returns of professionals in {shots['match'].nunique()} matches, "
        f"each evaluated by a model trained without its match "
        f"({run.params.shot_quality.folds} folds). "
    )
    yield ReportFigure(
        calibration_figure(calibration, float(shots["wins"].mean())),
        "calibration",
        title="Calibration of the winning probability",
        caption=f"{caption}Each point is an eighth of the shots, sorted by probability.",
    )
    yield ReportTable(calibration, "calibration", title="Calibration", caption=caption)
    yield ReportTable(
        run.kept("shot_quality", "scores"),
        "scores",
        title="Classification of winning shots",
        caption=f"{caption}outcome wins: this shot won the point, which the forest estimates; "
        "point: its player won the point in the end, which later shots decide. share: of the "
        "shots with that outcome. ROC-AUC: 0.5 is uninformative; the base rate is slightly "
        "below because it is that of the other matches. Brier score: smaller is better. 95 % "
        "intervals (low, high) are bootstrapped over matches.",
    )
    yield ReportTable(
        run.kept("shot_quality", "importance"),
        "importance",
        title="Permutation importance of the forest's features",
        caption=f"{caption}Decrease of the ROC-AUC when a feature is permuted among shots: "
        "mean and standard deviation of five permutations. Correlated features share their "
        "importance, so each seems to matter less than it does. most_correlated: the feature "
        "with the strongest rank correlation.",
    )


def _receivers(run: StageRun) -> Iterator[ReportItem]:
    caption = (
        f"Forests trained on {run.params.shot_quality.points} simulated points each, between "
        "professionals and a receiver whose reach or errors are a third smaller or larger, in "
        "another arena. Only shots of the unchanged player count."
    )
    yield ReportTable(
        run.kept("shot_quality", "receivers"),
        "receivers",
        title="Sensitivity to the receiver",
        caption=f"{caption} reach, error: factors. win_rate: share of the shots that won. "
        "order_agreement: share of the pairs of predictors, on the same set and horizons, "
        "whose medians have the same order as with the nominal receiver. nominal_repeat: the "
        "nominal receiver on other points, which shows the effect of chance alone.",
    )
    yield ReportTable(
        run.kept("shot_quality", "medians"),
        "win_probability",
        title="Winning probabilities with other receivers and labels",
        caption=f"Medians over the returns. {caption} as_measured: the forest of the other "
        "tables. point: the same shots, labelled by who won the point in the end.",
    )


def medians_figure(table: pd.DataFrame, metrics: dict[str, str]) -> Figure:
    """Draw a panel a metric: its medians for every set, predictor and horizons, with intervals.

    Args:
        table: one row a ``set``, ``horizons_ms`` and ``predictor``, with the metrics' columns and
            the ends of their intervals, ``..._low`` and ``..._high``.
        metrics: column to title.
    """
    sets, horizons = list(table["set"].unique()), list(table["horizons_ms"].unique())
    hatches = {name: HATCH if name == horizons[0] else "" for name in horizons}
    predictors = sorted(
        table["predictor"].unique(), key=lambda name: (name != "physics", predictor_order(name))
    )
    indices = {pair: index for index, pair in enumerate(product(predictors, horizons))}
    width = BARS / len(indices)
    figure = Figure(figsize=(FIGURE_WIDTH, 1.0 + 1.75 * len(metrics)))
    grid = figure.subplots(len(metrics), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (column, title) in zip(grid, metrics.items(), strict=True):
        for row in table[table[column].notna()].to_dict("records"):
            index = indices[row["predictor"], row["horizons_ms"]]
            median, low, high = row[column], row[f"{column}_low"], row[f"{column}_high"]
            axes.bar(
                sets.index(row["set"]) - BARS / 2 + (index + 0.5) * width, median, 0.9 * width,
                color=physics_colour(row["predictor"]), edgecolor="white", linewidth=0.0,
                hatch=hatches[row["horizons_ms"]],
                yerr=[[max(median - low, 0)], [max(high - median, 0)]],
                error_kw=WHISKERS | {"capsize": 1.5},
            )  # fmt: skip
        axes.grid(visible=False, axis="x")
        axes.set_title(title)
    grid[-1].set_xticks(range(len(sets)), [set_label(name) for name in sets])
    handles = [
        Patch(color=physics_colour(name), label=predictor_label(name)) for name in predictors
    ]
    handles += [
        Patch(facecolor="none", edgecolor=MUTED, hatch=hatch, label=f"{name} ms")
        for name, hatch in hatches.items()
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=4)
    return figure


def calibration_figure(table: pd.DataFrame, share: float) -> Figure:
    """Draw the share of the shots that won over their estimated probability.

    Args:
        table: one row a ``method`` and bin, with ``probability`` and ``share``.
        share: of all shots that won.
    """
    figure = Figure(figsize=(FIGURE_WIDTH / 2, 3.4))
    axes = figure.subplots()
    end = 1.05 * table[["probability", "share"]].to_numpy().max()
    axes.plot([0, end], [0, end], color=MUTED, lw=0.9, label="perfect calibration")
    axes.axhline(share, color=MUTED, lw=0.9, ls=":", label="base rate")
    for method, colour in METHOD_COLOURS.items():
        rows = table[table["method"] == method]
        axes.plot(rows["probability"], rows["share"], ".-", color=colour, label=method)
    axes.set(xlabel="estimated winning probability", ylabel="share of shots that won")
    axes.set(xlim=(0, end), ylim=(0, end))
    axes.legend()
    return figure
