"""From the content of the sources to the tables of recordings and their manifest."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from rallygap.pipeline.io.artifacts import table_writer
from rallygap.pipeline.io.schemas import LAUNCHES, POINTS, RECORDINGS, TRUE_CONTACTS, checked, empty
from rallygap.pipeline.io.source_manifest import Manifest, SourceRecord
from rallygap.pipeline.params import IngestSettings
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.registry import find_source
from rallygap.pipeline.sources.source import RawTable, SourceContext
from rallygap.pipeline.sources.source_import import SourceImport, in_batches

EXTRA_TABLES = {"points": POINTS, "true_contacts": TRUE_CONTACTS}  # of simulated recordings
TABLES = {"recordings": RECORDINGS, "launches": LAUNCHES, **EXTRA_TABLES}


@dataclass(frozen=True)
class Gathered:
    """What the sources are.

    Attributes:
        manifest: of all sources.
        folders: the folder of every source that reads files.
        truth: the physics of the simulated source; ``None`` if all were measured.
    """

    manifest: Manifest
    folders: dict[str, Path]
    truth: dict[str, Any] | None


def gather(settings: IngestSettings, seed: int, folder: Path) -> Gathered:
    """Read every source that the settings list, and write their rows as ``TABLES``.

    Rows are written batch by batch, since a source may not fit into memory. A row group of a table
    has recordings of one source, each of them whole.

    Args:
        settings: sources and their folder.
        seed: of simulated sources.
        folder: of ``<table>.parquet``, which do not change if anything fails.

    Raises:
        InputError: a source is unknown, its folder is missing, or a file as a whole is not what
            the source reads.
    """
    context = SourceContext(settings, seed)
    records: dict[str, SourceRecord] = {}
    folders: dict[str, Path] = {}
    truth = None
    with ExitStack() as stack:
        writers = {
            name: stack.enter_context(table_writer(folder / f"{name}.parquet", empty(schema)))
            for name, schema in TABLES.items()
        }

        def add(table: str, rows: pd.DataFrame) -> None:
            writers[table](checked(rows, TABLES[table]))

        for listed in settings.sources:
            data = find_source(listed).read(context)
            name = data.description.name
            if name in records:
                problem = f"two sources are called {name}; rename one in its source.yaml"
                raise InputError("params.yaml", problem, field="ingest.sources")
            imported = SourceImport(data)
            table = "launches" if imported.is_launches else "recordings"
            for batch in in_batches(data.tables):
                add(table, imported.rows(batch))
                for extra in EXTRA_TABLES:
                    add(extra, _extra_rows(batch, extra, name))
            records[name] = imported.record()
            if imported.folder is not None:
                folders[name] = imported.folder
            truth = data.truth or truth
    return Gathered(Manifest(sources=records), folders, truth)


def _extra_rows(batch: Sequence[RawTable], table: str, source: str) -> pd.DataFrame:
    """Return the rows of the recordings of a batch for one of ``EXTRA_TABLES``."""
    parts = {raw.name: raw.extra_tables[table] for raw in batch if table in raw.extra_tables}
    nothing = empty(EXTRA_TABLES[table])
    if not parts:
        return nothing
    rows = pd.concat(parts.values(), ignore_index=True)
    ids = np.repeat([f"{source}/{name}" for name in parts], [len(part) for part in parts.values()])
    rows.insert(0, "recording_id", ids)
    return rows.astype(nothing.dtypes)
