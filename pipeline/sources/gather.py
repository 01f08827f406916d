"""From what the sources hold to the tables of measured balls and their manifest."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pandera.pandas import DataFrameSchema

from pipeline.io.artifacts import table_writer
from pipeline.io.schemas import LAUNCHES, POINTS, RECORDINGS, TRUE_CONTACTS, checked, empty
from pipeline.runtime.errors import InputError
from pipeline.sources.intake import Intake, in_batches
from pipeline.sources.manifest import Manifest, SourceRecord
from pipeline.sources.registry import find_source
from pipeline.sources.settings import IngestSettings
from pipeline.sources.source import RawTable, SourceContext, SourceData

Add = Callable[[pd.DataFrame], None]

TABLES = {
    "recordings": RECORDINGS,
    "launches": LAUNCHES,
    "points": POINTS,
    "true_contacts": TRUE_CONTACTS,
}
BESIDE = ("points", "true_contacts")  # what simulated recordings bring along


@dataclass(frozen=True)
class Gathered:
    """What there is to say about the measured balls of all sources.

    Attributes:
        manifest: where they come from.
        folders: the folder of every source that reads files.
        truth: the physics behind the simulated ones; ``None`` if all were measured.
    """

    manifest: Manifest
    folders: dict[str, Path]
    truth: dict[str, Any] | None


def gather(settings: IngestSettings, seed: int, folder: Path) -> Gathered:
    """Read every source that the settings list, and write what they hold as ``TABLES``.

    Rows go to the files as they come: a source need not fit into memory. A row group of a table
    has recordings of one source, each of them whole.

    Args:
        settings: which sources to read, and from where.
        seed: of the simulated ones.
        folder: where ``<table>.parquet`` go; they are left as they were if anything fails.

    Raises:
        InputError: a source is unknown, its folder is missing, or a file as a whole is not what
            the source reads.
    """
    context = SourceContext(settings, seed)
    records: dict[str, SourceRecord] = {}
    folders: dict[str, Path] = {}
    truth = None
    with ExitStack() as stack:
        add = {name: _checking(stack, folder, name) for name in TABLES}
        for listed in settings.sources:
            data = find_source(listed).read(context)
            name = data.description.name
            if name in records:
                problem = f"two sources are called {name}; rename one in its source.yaml"
                raise InputError("params.yaml", problem, field="ingest.sources")
            intake = Intake(data)
            _take_over(data, intake, add)
            records[name] = intake.record()
            if intake.folder is not None:
                folders[name] = intake.folder
            truth = data.truth or truth
    return Gathered(Manifest(sources=records), folders, truth)


def _checking(stack: ExitStack, folder: Path, name: str) -> Add:
    """Return a function that adds rows to a table if they keep its contract."""
    contract: DataFrameSchema = TABLES[name]
    add = stack.enter_context(table_writer(folder / f"{name}.parquet", empty(contract)))
    return lambda rows: add(checked(rows, contract))


def _take_over(data: SourceData, intake: Intake, add: dict[str, Add]) -> None:
    """Add what a source holds to the tables."""
    table = "launches" if intake.is_launches else "recordings"
    for batch in in_batches(data.tables):
        add[table](intake.take(batch))
        for name in BESIDE:
            add[name](_beside(batch, name, data.description.name))


def _beside(batch: Sequence[RawTable], table: str, source: str) -> pd.DataFrame:
    """Return the rows that the recordings of a batch bring along for ``table``."""
    found = {raw.name: raw.beside[table] for raw in batch if table in raw.beside}
    if not found:
        return empty(TABLES[table])
    rows = pd.concat(found.values(), ignore_index=True)
    ids = np.repeat([f"{source}/{name}" for name in found], [len(part) for part in found.values()])
    rows.insert(0, "recording_id", ids)
    return rows.astype(empty(TABLES[table]).dtypes)
