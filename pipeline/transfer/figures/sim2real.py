"""Figures of sim-to-real: hit and return rates, and tolerated forecast errors."""

from itertools import cycle
from textwrap import fill

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rallygap.pipeline.io.figure_style import (
    FIGURE_WIDTH,
    INK,
    MUTED,
    predictor_colour,
    predictor_order,
)
from rallygap.pipeline.io.labels import predictor_label
from rallygap.pipeline.transfer.figures.sample import sample, trainings
from rallygap.pipeline.transfer.transfer_table import PROTOCOLS

Forecaster = tuple[str, str]  # predictor and protocol

# Physics uses the policies' own simulator.
PHYSICS_COLOURS = {"first_window": "#8fc4e8", "every_tick": predictor_colour("physics_c")}
BARS = 0.84  # width of all bars of a set; sets are 1 apart
LABEL = 12  # letters per line of a set's name
HITS = 0.35  # opacity of hits, behind the returns
ERRORS = {"bias": "constant bias", "noise": "noise at every control step"}
LINES = ("#0f7fc4", "#d55e00", "#009988", "#8a6fd1")


def transfer_figure(rates: pd.DataFrame) -> Figure:
    """Draw return rates, in front of hit rates, of every set with every predictor.

    Args:
        rates: one row per ``set``, ``horizons_ms``, ``predictor`` and ``protocol``, with ``balls``,
            ``trainings``, ``hit_rate``, ``return_rate``, ``return_rate_low`` and
            ``return_rate_high``.
    """
    horizons = list(rates["horizons_ms"].unique())
    sets = rates.groupby("set", sort=False)["balls"].first()
    forecasters = _forecasters(rates)
    figure = Figure(figsize=(FIGURE_WIDTH, 1.2 + 2.3 * len(horizons)))
    grid = figure.subplots(len(horizons), 1, squeeze=False, sharex=True, sharey=True)[:, 0]
    for axes, ahead in zip(grid, horizons, strict=True):
        panel = rates[rates["horizons_ms"] == ahead]
        _draw_panel(axes, panel, forecasters, list(sets.index))
        axes.set_title(f"horizons {ahead.replace('-', '–')} ms")
    names = [f"{fill(_words(str(name)), LABEL)}\nn = {count}" for name, count in sets.items()]
    grid[-1].set_xticks(range(len(names)), names)
    _add_legends(figure, forecasters, trainings(rates))
    return figure


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
        for (ahead, own), colour in zip(rates.groupby("horizons_ms"), cycle(LINES), strict=False):
            _draw_line(axes, own[own["error"] == error].sort_values("size_cm"), colour, str(ahead))
            spinless = 100 * own.loc[own["error"] == "no_spin", "return_rate"].iloc[0]
            axes.axhline(spinless, color=colour, lw=1.0, ls=":", label=f"{ahead} ms, zero spin")
        axes.set(title=title, xlabel="forecast position error (cm)", ylim=(0, 104))
        axes.set_xlim(left=0)
    panels[0].set_ylabel("return rate (%)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper left", ncols=4, title=sample(rates), alignment="left"
    )
    return figure


def _forecasters(rates: pd.DataFrame) -> list[Forecaster]:
    """Return physics with both protocols first, then the others."""
    pairs = rates[["predictor", "protocol"]].drop_duplicates().to_numpy(dtype=str)

    def place(forecaster: Forecaster) -> tuple[bool, tuple[int, str], bool]:
        name, protocol = forecaster
        return name != "physics", predictor_order(name), protocol == "every_tick"

    return sorted(((str(name), str(protocol)) for name, protocol in pairs), key=place)


def _draw_panel(
    axes: Axes, rates: pd.DataFrame, forecasters: list[Forecaster], sets: list[str]
) -> None:
    width = BARS / len(forecasters)
    for place, (name, protocol) in enumerate(forecasters):
        rows = rates[(rates["predictor"] == name) & (rates["protocol"] == protocol)]
        offset = (place - (len(forecasters) - 1) / 2) * width
        across = [sets.index(one) + offset for one in rows["set"]]
        height, colour = 100 * rows["return_rate"], _colour((name, protocol))
        ends = [height - 100 * rows["return_rate_low"], 100 * rows["return_rate_high"] - height]
        whiskers = {"ecolor": INK, "elinewidth": 0.9, "capsize": 2}
        axes.bar(across, 100 * rows["hit_rate"], 0.9 * width, color=colour, alpha=HITS)
        axes.bar(across, height, 0.9 * width, color=colour, yerr=ends, error_kw=whiskers)
    axes.set(ylabel="rate (% of shots)", ylim=(0, 104), yticks=range(0, 101, 25))
    axes.grid(visible=False, axis="x")


def _draw_line(axes: Axes, rows: pd.DataFrame, colour: str, ahead: str) -> None:
    low, high = 100 * rows["return_rate_low"], 100 * rows["return_rate_high"]
    axes.fill_between(rows["size_cm"], low, high, color=colour, alpha=0.22, lw=0)
    axes.plot(rows["size_cm"], 100 * rows["return_rate"], ".-", color=colour, label=f"{ahead} ms")


def _add_legends(figure: Figure, forecasters: list[Forecaster], per_bar: str) -> None:
    bars = [
        Patch(
            color=_colour((name, protocol)), label=f"{predictor_label(name)}, {PROTOCOLS[protocol]}"
        )
        for name, protocol in forecasters
    ]
    parts = [
        Patch(color=MUTED, label="returned"),
        Patch(color=MUTED, alpha=HITS, lw=0, label="hit"),
        Line2D([], [], color=INK, lw=0.9, label="95 % interval of the return rate"),
    ]
    figure.legend(handles=bars, loc="outside upper left", ncols=2)
    figure.legend(handles=parts, loc="outside lower center", ncols=3, title=f"{per_bar} per bar")


def _colour(forecaster: Forecaster) -> str:
    name, protocol = forecaster
    return PHYSICS_COLOURS[protocol] if name == "physics" else predictor_colour(name)


def _words(name: str) -> str:
    return name.replace("_", " ")
