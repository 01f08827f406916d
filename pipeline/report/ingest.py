"""The report of `ingest`: what was read, where the balls are, how launches differ."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from scipy.stats import ks_2samp

from rallygap.models.ball.state import NET_HEIGHT, NET_OVERHANG, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.pipeline.io.artifacts import read_table
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, VELOCITY_COLUMNS
from rallygap.pipeline.io.source_manifest import Manifest, SourceRecord, read_manifest
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.sources.launches import MEASURED, QUANTITIES
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, INK, MUTED
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable

BALL_COLOUR = "#0f7fc4"
TABLE_COLOUR = "#dfe9e4"
DRAWN_BALLS = 20_000  # of a source; more only darken the panel
DRAWN_RUN = 200  # successive balls, that paths can be seen
DRAWN_LAUNCHES = 600
LAUNCH_SECONDS = 0.03  # of flight that a launch's arrow stands for
VIEWS = {"from the side": (1, 2), "from above": (1, 0)}  # the axes drawn across and up
AXIS_LABELS = ["x (m)", "y (m)", "z (m)"]
LIMITS = [(-1.3, 1.3), (-2.4, 2.4), (-0.9, 1.7)]  # m

QUANTILES = {"5%": 0.05, "25%": 0.25, "50%": 0.5, "75%": 0.75, "95%": 0.95}
# The measured strokes are those of amateurs and club players.
COMPARED = "amateur and club"
STROKES = {"rallies and cannon": ("rally", "cannon"), "serves": ("serve",)}  # by panel
CUT_TAILS = 0.002  # of a panel's launches on each side, for a readable scale
LINES: dict[str, dict[str, Any]] = {
    "cannon": {"color": MUTED, "ls": ":"},
    "amateur": {"color": "#0f7fc4"},
    "club": {"color": "#009988"},
    "semi_pro": {"color": "#b85fa0"},
    "pro": {"color": "#d55e00"},
    MEASURED: {"color": INK, "lw": 2.6},
}


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield measured positions, sources, and the launches as a figure, if any, and as a table."""
    manifest = read_manifest(run.input("ingest", "manifest.json"))
    yield ReportFigure(
        measured_balls_figure(_drawn_balls(manifest, run.input("ingest", ""))),
        "measured_balls",
        title="Measured trajectories",
        caption="Measured positions in the table frame, outliers too, and launches with the way "
        "they take in 30 ms; an even choice where a source has many. The robot stands at y < 0.",
    )
    yield ReportTable(
        pd.DataFrame([_source_row(record) for record in manifest.sources.values()]),
        "sources",
        title="Sources",
        caption="What was read, what was refused and why; artifacts/ingest/manifest.json has every "
        "refused row and every file's checksum.",
    )
    launches = run.kept("ingest", "launches")
    if len(launches):
        yield ReportFigure(
            launches_figure(launches),
            "launches",
            title="Speed, direction and spin of launches",
            caption="Distribution functions of simulated launches by level, as they truly were, "
            "and of measured ones where a source has them. Height is above the table; direction "
            "from straight ahead, to the right of the player who hits the ball.",
        )
    yield ReportTable(
        launch_distributions(launches),
        "launch_distributions",
        title="Launches in numbers",
        caption="Quantiles, and the largest distance between a group's distribution function and "
        "that of the measured launches of the same stroke (0 the same, 1 apart).",
    )


def _drawn_balls(manifest: Manifest, artifacts: Path) -> dict[str, pd.DataFrame]:
    """Read the rows that the figure draws; the rows of a source are consecutive."""
    first = dict.fromkeys(["recordings", "launches"], 0)
    drawn = {}
    for name, record in manifest.sources.items():
        is_launches = record.kind == "launches"
        table = "launches" if is_launches else "recordings"
        columns = POSITION_COLUMNS + (VELOCITY_COLUMNS if is_launches else [])
        rows = first[table] + drawn_rows(record.rows_kept, launches=is_launches)
        drawn[name] = read_table(artifacts / f"{table}.parquet", columns).iloc[rows]
        first[table] += record.rows_kept
    return drawn


def _source_row(record: SourceRecord) -> dict[str, Any]:
    kinds = record.kind.values() if isinstance(record.kind, dict) else [record.kind]
    refused = record.refused_counts
    return {
        "source": record.name,
        "kind": ", ".join(dict.fromkeys(kinds)),
        "recordings": record.recordings or record.launches,
        "rows": record.rows_kept,
        "rate (Hz)": record.rate_hz,
        "spin": record.spin.replace("_", " "),
        "refused": ", ".join(f"{count} {reason}" for reason, count in refused.items()),
        "licence": record.licence,
        "note": record.note,
    }


def drawn_rows(rows: int, *, launches: bool) -> NDArray[np.int64]:
    """Return which of a source's rows to draw, ascending: evenly chosen launches or runs of balls.

    Args:
        rows: how many there are.
        launches: whether they are launches; successive ones have nothing to do with each other.
    """
    run, most = (1, DRAWN_LAUNCHES) if launches else (DRAWN_RUN, DRAWN_BALLS)
    if rows <= most:
        return np.arange(rows)
    starts = np.linspace(0, rows - run, most // run).astype(np.int64)
    return (starts[:, None] + np.arange(run)).ravel()


def measured_balls_figure(sources: dict[str, pd.DataFrame]) -> Figure:
    """Draw measured positions of every source, with table and net.

    Args:
        sources: name -> positions (columns px, py, pz; m, table frame), as many as ``drawn_rows``
            says. Where velocities (vx, vy, vz; m/s) are there too, each row is a launch and drawn
            with its way.
    """
    figure = Figure(figsize=(FIGURE_WIDTH, 0.4 + 2.2 * len(sources)))
    grid = figure.subplots(len(sources), len(VIEWS), squeeze=False)
    for axes_row, (name, balls) in zip(grid, sources.items(), strict=True):
        for axes, (view, (along, up)) in zip(axes_row, VIEWS.items(), strict=True):
            _draw_table(axes, from_above=up == 0)
            _draw_balls(axes, balls, along, up)
            axes.set(xlabel=AXIS_LABELS[along], ylabel=AXIS_LABELS[up], aspect="equal")
            # Seen from above with y to the right, x points down.
            axes.set(xlim=LIMITS[along], ylim=LIMITS[up] if up == 2 else LIMITS[up][::-1])
            axes.set_title(view)
        axes_row[0].set_title(f"{name}, {next(iter(VIEWS))}")
    return figure


def _draw_table(axes: Axes, *, from_above: bool) -> None:
    bottom, height = (-TABLE_HALF_WIDTH, 2 * TABLE_HALF_WIDTH) if from_above else (-0.03, 0.03)
    size = (2 * TABLE_HALF_LENGTH, height)
    axes.add_patch(
        Rectangle((-TABLE_HALF_LENGTH, bottom), *size, facecolor=TABLE_COLOUR, edgecolor=MUTED)
    )
    reach = TABLE_HALF_WIDTH + NET_OVERHANG
    net = (-reach, reach) if from_above else (0, NET_HEIGHT)
    axes.plot([0, 0], net, color=INK, lw=1.2)


def _draw_balls(axes: Axes, balls: pd.DataFrame, along: int, up: int) -> None:
    start = balls[POSITION_COLUMNS].to_numpy()
    axes.plot(start[:, along], start[:, up], ".", ms=1.8, alpha=0.5, mew=0, color=BALL_COLOUR)
    if VELOCITY_COLUMNS[0] in balls:
        end = start + LAUNCH_SECONDS * balls[VELOCITY_COLUMNS].to_numpy()
        across, upwards = np.stack([start, end])[:, :, [along, up]].transpose(2, 0, 1)
        axes.plot(across, upwards, color=BALL_COLOUR, lw=0.6, alpha=0.4)


def launch_distributions(launches: pd.DataFrame) -> pd.DataFrame:
    """Return quantiles of every quantity, and how far each group is from the measured launches.

    Args:
        launches: of all groups, in the columns of ``simulated_launches``.

    Returns:
        One row a stroke, quantity and group; the distance is the largest between the distribution
        functions, after Kolmogorov, where launches of the same stroke were measured.
    """
    columns = ["stroke", "quantity", "group", "launches", *QUANTILES, "distance to measured"]
    return pd.DataFrame(list(_distributions(launches)), columns=columns)


def launches_figure(launches: pd.DataFrame) -> Figure:
    """Draw the distribution function of every quantity, one line a group.

    Args:
        launches: of all groups, in the columns of ``simulated_launches``; at least one.
    """
    panels = {
        title: launches[launches["stroke"].isin(strokes)] for title, strokes in STROKES.items()
    }
    panels = {title: drawn for title, drawn in panels.items() if len(drawn)}
    figure = Figure(figsize=(FIGURE_WIDTH, 0.5 + 1.45 * len(QUANTITIES)))
    grid = figure.subplots(len(QUANTITIES), len(panels), squeeze=False, sharey=True)
    for column, (title, drawn) in zip(grid.T, panels.items(), strict=True):
        column[0].set_title(title)
        for axes, (quantity, unit) in zip(column, QUANTITIES.items(), strict=True):
            _draw_distributions(axes, drawn, quantity)
            axes.set_xlabel(f"{quantity} ({unit})")
    figure.supylabel("share of launches below", fontsize="medium")
    lines = {line.get_label(): line for axes in grid[0] for line in axes.lines}
    figure.legend(handles=list(lines.values()), loc="outside upper center", ncols=len(lines))
    return figure


def _distributions(launches: pd.DataFrame) -> Iterator[tuple[Any, ...]]:
    amateurs = launches[launches["group"].isin(["amateur", "club"])].assign(group=COMPARED)
    for stroke, of_stroke in pd.concat([launches, amateurs]).groupby("stroke"):
        groups = dict(list(of_stroke.groupby("group", sort=False)))
        for quantity, unit in QUANTITIES.items():
            for name, group in groups.items():
                values = group[quantity]
                distance = np.nan
                if MEASURED in groups and name != MEASURED:
                    test = ks_2samp(values, groups[MEASURED][quantity], method="asymp")
                    distance = float(test.statistic)
                quantiles = values.quantile(list(QUANTILES.values()))
                yield stroke, f"{quantity} ({unit})", name, len(values), *quantiles, distance


def _draw_distributions(axes: Axes, launches: pd.DataFrame, quantity: str) -> None:
    for group, line in LINES.items():
        values = launches[quantity][launches["group"] == group]
        if len(values):
            axes.ecdf(values, label=group.replace("_", "-"), **{"lw": 1.5, **line})
    low, high = launches[quantity].quantile([CUT_TAILS, 1 - CUT_TAILS])
    if low < high:
        axes.set_xlim(low, high)
