"""The report of `sim2real`: hit and return rates, and tolerated forecast errors."""

from collections.abc import Iterator, Sequence
from itertools import cycle
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rallygap.pipeline.paper.values import printed_transfer
from rallygap.pipeline.report.plots import (
    BARS,
    WHISKERS,
    add_legend,
    ahead,
    percent,
    physics_colour,
    sample,
    set_label,
    trainings,
)
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.rates import OUTCOMES
from rallygap.pipeline.transfer.returns import EVERY_STEP, PHYSICS, PROTOCOLS
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, MUTED, predictor_order
from rallygap.pipeline.web.labels import predictor_label
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

Forecaster = tuple[str, str]  # predictor and protocol

FIRST_WINDOW = "#8fc4e8"  # colour of physics that forecasts once
HITS = 0.35  # opacity of hits, behind the returns
ERRORS = {"bias": "constant bias", "noise": "noise at every control step"}
PAPER_ROW = "the paper's"
COUNTS = [outcome.counts for outcome in OUTCOMES]
LINES = ("#0f7fc4", "#d55e00", "#009988", "#8a6fd1")


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield hits and returns, the replayed shots, and the forecast errors that are tolerated."""
    caption, rates = _caption(run), run.kept("sim2real", "rates")
    yield ReportFigure(
        transfer_figure(rates),
        "transfer",
        title="Sim-to-real: hits and returns of replayed shots",
        caption=caption,
    )
    yield ReportTable(
        paper_form_table(rates, run.params.sim2real.learned),
        "transfer",
        title="Sim-to-real, in the form of the paper's table",
        caption=f"{caption} Numbers of shots, means over policies that differ only in the "
        "seed. Physics and the learned predictor both forecast at every control step. The "
        "paper has other shots, another robot and another policy: only the gains of the "
        "learned predictor compare.",
    )
    yield ReportTable(
        rates,
        "rates",
        title="Sim-to-real: all predictors",
        caption="Rates over the replayed shots with 95 % intervals (low, high) "
        "over trainings and recordings; hits and returns are numbers of shots, means over "
        "policies. "
        "forecast_error_cm: mean distance between forecast and true position at the middle "
        "horizon, over all control steps before the ball is out of play.",
    )
    yield ReportTable(
        run.kept("sim2real", "differences"),
        "difference",
        title="Sim-to-real: gains over physics at every control step",
        caption="Difference of the rates with the predictor and with physics, paired by shot, "
        "with 95 % intervals over trainings and recordings. p_holm: Holm's "
        "correction of p for all comparisons of the table. gained, lost: shots with the "
        "outcome more often with the predictor, or with physics.",
    )
    yield ReportTable(
        run.kept("sim2real", "differences_first_window"),
        "difference_first_window",
        title="Sim-to-real: gains over physics from the first window",
        caption="As the table before, but the difference to physics that forecasts once, from "
        "the first window.",
    )
    yield ReportTable(
        run.kept("sim2real", "replayed"),
        "replayed",
        title="Replayed shots",
        caption="Shots that no predictor was trained on. in_reach: those that pass through the "
        "racket's workspace; the others are played, too. rotated: those that flew the other "
        "way and were rotated by half a turn. excluded: with the reason. spin: how it was "
        "measured; without labels a ball starts without spin, and its bounce changes the spin "
        "according to the change of velocity. physics: of the flight beyond the measurements "
        "and after the racket.",
    )
    settings = run.params.sim2real
    caption = (
        f"{settings.tolerance.shots} test shots of the policies' own simulator with exact "
        "forecasts but for one error. bias: forecast positions shifted in one random direction "
        "per shot; noise: shifted independently at every control step, with this root mean "
        "square; no_spin: forecast spin set to zero. 95 % intervals are over "
        "trainings and shots."
    )
    title = "Tolerated forecast errors"
    tolerance = run.kept("sim2real", "tolerance")
    yield ReportFigure(tolerance_figure(tolerance), "tolerance", title, caption)
    yield ReportTable(tolerance, "tolerance", title, caption)


def _caption(run: StageRun) -> str:
    simulator = run.params.sim2real.simulator
    return (
        f"Policies trained in the simulator {simulator} play measured shots. Physics: a Kalman "
        f"filter over the last 12 measurements with {simulator}; first window: one forecast of "
        "the whole flight from the first 12 measurements; every control step: a new forecast "
        "every 40 ms, as for all other predictors. Amended: the same filter with the simulator as "
        "close_gap amended it from the source's training shots. Oracle: the physics that flew "
        "the ball. After the racket, arena balls fly in the arena's physics, measured balls in the "
        "literature's."
    )


def paper_form_table(table: pd.DataFrame, learned: Sequence[str]) -> pd.DataFrame:
    """Return numbers of hits and returns with physics and with learned predictors.

    Args:
        table: ``rates`` by set, horizons, predictor and protocol.
        learned: predictors to compare with physics.

    Returns:
        One row per set and learned predictor, and the paper's row for each set that it has.
    """
    every_step = table[table["protocol"] == EVERY_STEP]
    horizons = list(table["horizons_ms"].unique())
    rows = []
    for name, members in every_step.groupby("set", sort=False):
        rows += [_row(members, str(name), predictor) for predictor in learned]
        if name in printed_transfer():
            rows.append(_paper_row(str(name), horizons))
    return pd.DataFrame(rows)


def _row(members: pd.DataFrame, name: str, learned: str) -> dict[str, Any]:
    row = {"set": name, "learned_predictor": learned, "shots": members["balls"].iloc[0]}
    for horizons, rows in members.groupby("horizons_ms", sort=False):
        for kind, predictor in (("physics", PHYSICS), ("learned", learned)):
            counts = rows[rows["predictor"] == predictor].iloc[0]
            row |= {f"{horizons} ms: {kind} {count}": counts[count] for count in COUNTS}
    return row


def _paper_row(name: str, horizons: Sequence[str]) -> dict[str, Any]:
    printed = printed_transfer()[name]
    row = {"set": name, "learned_predictor": PAPER_ROW, "shots": printed.shots}
    for label in horizons:
        for kind, counts in printed.counts.get(label, {}).items():
            row |= {f"{label} ms: {kind} {outcome}": count for outcome, count in counts.items()}
    return row


def transfer_figure(rates: pd.DataFrame) -> Figure:
    """Draw return rates, in front of hit rates, of every set with every predictor.

    Args:
        rates: one row per ``set``, ``horizons_ms``, ``predictor`` and ``protocol``, with ``balls``,
            ``trainings``, ``hit_rate``, ``return_rate``, ``return_rate_low`` and
            ``return_rate_high``.
    """
    horizons = list(rates["horizons_ms"].unique())
    sets = rates.groupby("set", sort=False)["balls"].first()
    pairs = rates[["predictor", "protocol"]].drop_duplicates().to_numpy(dtype=str)
    forecasters = sorted(((str(name), str(protocol)) for name, protocol in pairs), key=_place)
    figure = Figure(figsize=(FIGURE_WIDTH, 1.2 + 2.3 * len(horizons)))
    grid = figure.subplots(len(horizons), 1, squeeze=False, sharex=True, sharey=True)[:, 0]
    for axes, label in zip(grid, horizons, strict=True):
        _draw_rates(axes, rates[rates["horizons_ms"] == label], forecasters, list(sets.index))
        axes.set_title(f"horizons {ahead(label)}")
    names = [f"{set_label(name)}\nn = {count}" for name, count in sets.items()]
    grid[-1].set_xticks(range(len(names)), names)
    bars = [
        Patch(
            color=_colour(name, protocol), label=f"{predictor_label(name)}, {PROTOCOLS[protocol]}"
        )
        for name, protocol in forecasters
    ]
    parts = [
        Patch(color=MUTED, label="returned"),
        Patch(color=MUTED, alpha=HITS, lw=0, label="hit"),
        Line2D([], [], color=INK, lw=0.9, label="95 % interval of the return rate"),
    ]
    figure.legend(handles=bars, loc="outside upper left", ncols=2)
    title = f"{trainings(rates)} per bar"
    figure.legend(handles=parts, loc="outside lower center", ncols=3, title=title)
    return figure


def _place(forecaster: Forecaster) -> tuple[bool, tuple[int, str], bool]:
    """Return what sorts physics with both protocols first."""
    name, protocol = forecaster
    return name != "physics", predictor_order(name), protocol == "every_tick"


def _draw_rates(
    axes: Axes, rates: pd.DataFrame, forecasters: list[Forecaster], sets: list[str]
) -> None:
    width = BARS / len(forecasters)
    for place, (name, protocol) in enumerate(forecasters):
        rows = rates[(rates["predictor"] == name) & (rates["protocol"] == protocol)]
        offset = (place - (len(forecasters) - 1) / 2) * width
        across = [sets.index(row) + offset for row in rows["set"]]
        rate, ends = percent(rows)
        colour = _colour(name, protocol)
        axes.bar(across, 100 * rows["hit_rate"], 0.9 * width, color=colour, alpha=HITS)
        axes.bar(across, rate, 0.9 * width, color=colour, yerr=ends, error_kw=WHISKERS)
    axes.set(ylabel="rate (% of shots)", ylim=(0, 104), yticks=range(0, 101, 25))
    axes.grid(visible=False, axis="x")


def _colour(name: str, protocol: str) -> str:
    is_first = name == "physics" and protocol == "first_window"
    return FIRST_WINDOW if is_first else physics_colour(name)


def tolerance_figure(rates: pd.DataFrame) -> Figure:
    """Draw return rates over forecast errors: a panel per kind of error, a line per horizons.

    Args:
        rates: one row per ``error`` (``bias``, ``noise`` or ``no_spin``), ``size_cm`` and
            ``horizons_ms``, with ``balls``, ``trainings``, ``return_rate``, ``return_rate_low`` and
            ``return_rate_high``.
    """
    figure = Figure(figsize=(FIGURE_WIDTH, 3.4))
    panels = figure.subplots(1, len(ERRORS), sharey=True)
    for axes, (error, title) in zip(panels, ERRORS.items(), strict=True):
        for (label, own), colour in zip(rates.groupby("horizons_ms"), cycle(LINES), strict=False):
            rows = own[own["error"] == error].sort_values("size_cm")
            low, high = 100 * rows["return_rate_low"], 100 * rows["return_rate_high"]
            axes.fill_between(rows["size_cm"], low, high, color=colour, alpha=0.22, lw=0)
            rate = 100 * rows["return_rate"]
            axes.plot(rows["size_cm"], rate, ".-", color=colour, label=f"{label} ms")
            spinless = 100 * own.loc[own["error"] == "no_spin", "return_rate"].iloc[0]
            axes.axhline(spinless, color=colour, lw=1.0, ls=":", label=f"{label} ms, zero spin")
        axes.set(title=title, xlabel="forecast position error (cm)", ylim=(0, 104))
        axes.set_xlim(left=0)
    panels[0].set_ylabel("return rate (%)")
    where = {"loc": "outside upper left", "alignment": "left"}
    add_legend(figure, panels[0], ncols=4, title=sample(rates), **where)
    return figure
