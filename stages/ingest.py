"""Read the measured balls of every source into tables."""

from typing import Any

import pandas as pd

from pipeline.io.artifacts import read_rows, read_table, write_json
from pipeline.io.report_items import ReportFigure, ReportTable
from pipeline.io.schemas import POSITION_COLUMNS, VELOCITY_COLUMNS
from pipeline.runtime.stage_run import StageRun, run_stage
from pipeline.sources.figures.launches import (
    launch_distributions,
    launches_figure,
    measured_launches,
    simulated_launches,
)
from pipeline.sources.figures.measured_balls import drawn_rows, measured_balls_figure
from pipeline.sources.gather import Gathered, gather
from pipeline.sources.manifest import Manifest, Refused, SourceRecord


def ingest(run: StageRun) -> None:
    """Read, check and write down what the sources hold."""
    gathered = gather(run.params.ingest, run.seed, run.artifact("."))
    write_json(run.artifact("manifest.json"), gathered.manifest.model_dump(mode="json"))
    write_json(run.artifact("truth.json"), gathered.truth)
    _report_sources(run, gathered)
    _report_launches(run)


def _report_sources(run: StageRun, gathered: Gathered) -> None:
    sources = gathered.manifest.sources
    for name, record in sources.items():
        simulated = run.artifact("recordings.parquet")
        run.log_input(name, gathered.folders.get(name, simulated), record.rows_kept)
    run.write_metrics({name: _metrics(record) for name, record in sources.items()})
    run.add(
        ReportFigure(
            measured_balls_figure(_drawn_balls(run, gathered.manifest)),
            "measured_balls",
            title="Measured balls",
            caption="Measured positions in the table frame, outliers too, and launches with the "
            "way they take in 30 ms; an even choice where a source has many. The robot stands at y "
            "< 0.",
        ),
        ReportTable(
            _source_table(gathered.manifest),
            "sources",
            title="Sources",
            caption="What was read, what was refused and why; artifacts/ingest/manifest.json has "
            "every refused row and every file's checksum.",
        ),
    )


def _report_launches(run: StageRun) -> None:
    simulated = simulated_launches(read_table(run.artifact("true_contacts.parquet")))
    measured = measured_launches(read_table(run.artifact("launches.parquet")))
    launches = pd.concat([simulated, measured], ignore_index=True)
    if len(launches):
        run.add(
            ReportFigure(
                launches_figure(launches),
                "launches",
                title="How balls leave racket and cannon",
                caption="Distribution functions of simulated launches by level, as they truly "
                "were, and of measured ones where a source has them. Height is above the table; "
                "direction from straight ahead, to the right of the player who hits the ball.",
            )
        )
    run.add(
        ReportTable(
            launch_distributions(launches),
            "launch_distributions",
            title="Launches in numbers",
            caption="Quantiles, and the largest distance between a group's distribution function "
            "and that of the measured launches of the same stroke (0 the same, 1 apart).",
        )
    )


def _drawn_balls(run: StageRun, manifest: Manifest) -> dict[str, pd.DataFrame]:
    """Read of each source, whose rows lie together, those that the figure draws."""
    first = dict.fromkeys(["recordings", "launches"], 0)
    drawn = {}
    for name, record in manifest.sources.items():
        is_launches = record.kind == "launches"
        table = "launches" if is_launches else "recordings"
        columns = POSITION_COLUMNS + (VELOCITY_COLUMNS if is_launches else [])
        rows = first[table] + drawn_rows(record.rows_kept, launches=is_launches)
        drawn[name] = read_rows(run.artifact(f"{table}.parquet"), rows, columns)
        first[table] += record.rows_kept
    return drawn


def _metrics(record: SourceRecord) -> dict[str, Any]:
    metrics: dict[str, Any] = {
        "recordings": record.recordings,
        "launches": record.launches,
        "rows_read": record.rows_read,
        "rows_kept": record.rows_kept,
        "rows_refused": _counts(record.rows_refused),
        "labels_refused": _counts(record.labels_refused),
    }
    return metrics if record.rate_hz is None else {**metrics, "rate_hz": record.rate_hz}


def _counts(refused: dict[str, Refused]) -> dict[str, int]:
    return {reason: group.count for reason, group in refused.items()}


def _source_table(manifest: Manifest) -> pd.DataFrame:
    rows = []
    for record in manifest.sources.values():
        refused = {**record.rows_refused, **record.labels_refused}
        kinds = record.kind.values() if isinstance(record.kind, dict) else [record.kind]
        row = {
            "source": record.name,
            "kind": ", ".join(dict.fromkeys(kinds)),
            "recordings": record.recordings or record.launches,
            "rows": record.rows_kept,
            "rate (Hz)": record.rate_hz,
            "spin": record.spin.replace("_", " "),
            "refused": ", ".join(f"{group.count} {why}" for why, group in refused.items()),
            "licence": record.licence,
            "note": record.note,
        }
        rows.append(row)
    return pd.DataFrame(rows)


if __name__ == "__main__":
    run_stage(ingest)
