"""Read the measured balls of every source into one table."""

from typing import Any

import pandas as pd

from pipeline.artifacts import write_json, write_table
from pipeline.figures.measured_balls import measured_balls_figure
from pipeline.run import StageRun, run_stage
from pipeline.sources.gather import Gathered, gather
from pipeline.sources.manifest import Manifest, Refused, SourceRecord


def ingest(run: StageRun) -> None:
    """Read, check and write down what the sources hold."""
    gathered = gather(run.params.ingest, run.seed)
    write_table(run.artifact("recordings.parquet"), gathered.recordings)
    write_table(run.artifact("launches.parquet"), gathered.launches)
    write_json(run.artifact("manifest.json"), gathered.manifest.model_dump(mode="json"))
    for name, record in gathered.manifest.sources.items():
        simulated = run.artifact("recordings.parquet")
        run.log_input(name, gathered.folders.get(name, simulated), record.rows_kept)
    run.write_metrics(
        {name: _metrics(record) for name, record in gathered.manifest.sources.items()}
    )
    run.add_figure(
        measured_balls_figure(_balls_by_source(gathered)),
        "measured_balls",
        title="Measured balls",
        caption="Measured positions in the table frame, outliers too, and launches with the way "
        "they take in 30 ms; an even choice where a source has many. The robot stands at y < 0.",
    )
    run.add_table(
        _source_table(gathered.manifest),
        "sources",
        title="Sources",
        caption="What was read, what was refused and why; artifacts/ingest/manifest.json has every "
        "refused row and every file's checksum.",
    )


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


def _balls_by_source(gathered: Gathered) -> dict[str, pd.DataFrame]:
    """Return each source's rows; a source has either recordings or launches."""
    tables = {"recording_id": gathered.recordings, "launch_id": gathered.launches}
    return {
        str(source): rows
        for column, table in tables.items()
        for source, rows in table.groupby(table[column].str.split("/").str[0], sort=False)
    }


def _source_table(manifest: Manifest) -> pd.DataFrame:
    rows = []
    for record in manifest.sources.values():
        refused = {**record.rows_refused, **record.labels_refused}
        row = {
            "source": record.name,
            "kind": record.kind,
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
