"""The report of `ingest`: what was read, where the balls are, how launches differ."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from rallygap.pipeline.io.artifacts import read_table
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, VELOCITY_COLUMNS
from rallygap.pipeline.io.source_manifest import Manifest, SourceRecord, read_manifest
from rallygap.pipeline.report.launches import launch_distributions, launches_figure
from rallygap.pipeline.report.measured_balls import drawn_rows, measured_balls_figure
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.report_items import ReportFigure, ReportItem, ReportTable


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
