"""From what the sources hold to the tables of measured balls and their manifest."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from pandera.pandas import DataFrameSchema

from pipeline.contracts import LAUNCHES, RECORDINGS, checked
from pipeline.errors import InputError
from pipeline.sources.files import SourceFile
from pipeline.sources.manifest import FileRecord, Manifest, SourceRecord, by_reason
from pipeline.sources.registry import find_source
from pipeline.sources.settings import IngestSettings
from pipeline.sources.sieve import ONLY_SAMPLE, Sieve, sift_launches, sift_samples
from pipeline.sources.source import RawTable, Refusal, SourceContext, SourceData


@dataclass(frozen=True)
class Gathered:
    """Measured balls of all sources.

    Attributes:
        recordings: paths, keeping the contract ``RECORDINGS``.
        launches: states without a path, keeping the contract ``LAUNCHES``.
        manifest: where they come from.
        folders: the folder of every source that reads files.
    """

    recordings: pd.DataFrame
    launches: pd.DataFrame
    manifest: Manifest
    folders: dict[str, Path]


def gather(settings: IngestSettings, seed: int) -> Gathered:
    """Read every source that the settings list.

    Raises:
        InputError: a source is unknown, its folder is missing, or a file as a whole is not what
            the source reads.
    """
    context = SourceContext(settings, seed)
    recordings, launches = [_empty(RECORDINGS)], [_empty(LAUNCHES)]
    records: dict[str, SourceRecord] = {}
    folders: dict[str, Path] = {}
    for listed in settings.sources:
        data = find_source(listed).read(context)
        name = data.description.name
        if name in records:
            problem = f"two sources are called {name}; rename one in its source.yaml"
            raise InputError("params.yaml", problem, field="ingest.sources")
        table, records[name] = _take_over(data)
        if data.tables[0].file is not None:
            folders[name] = data.tables[0].file.path.parent
        (launches if data.description.kind == "launches" else recordings).append(table)
    return Gathered(
        checked(pd.concat(recordings, ignore_index=True), RECORDINGS),
        checked(pd.concat(launches, ignore_index=True), LAUNCHES),
        Manifest(sources=records),
        folders,
    )


def _take_over(data: SourceData) -> tuple[pd.DataFrame, SourceRecord]:
    """Return what of a source can be, in the table frame, and the record of the rest."""
    _check_names(data)
    is_launches = data.description.kind == "launches"
    sift = sift_launches if is_launches else sift_samples
    sieves = [sift(table, data.description.frame) for table in data.tables]
    _check_files(data.tables, sieves)
    named = (_launches if is_launches else _recordings)(data, sieves)
    if named.empty:
        raise InputError(data.description.name, "no recording has more than one sample")
    refusals = [*data.refusals, *(refusal for sieve in sieves for refusal in sieve.refusals)]
    record = SourceRecord(
        **dict(data.description),
        rate_hz=None if is_launches else _rate(named),
        recordings=0 if is_launches else named["recording_id"].nunique(),
        launches=len(named) if is_launches else 0,
        rows_read=sum(len(table.rows) + len(table.refusals) for table in data.tables),
        rows_kept=len(named),
        rows_refused=by_reason(refusal for refusal in refusals if refusal.what == "row"),
        labels_refused=by_reason(refusal for refusal in refusals if refusal.what == "label"),
        files=_file_records(data),
    )
    return named, record


def _check_names(data: SourceData) -> None:
    """Raise unless there are tables, each with a name of its own."""
    if not data.tables:
        raise InputError(data.description.name, "holds no recording")
    names = set()
    for table in data.tables:
        if table.name in names:
            where = data.description.name if table.file is None else table.file.path
            problem = f"a recording {table.name} was there before"
            raise InputError(where, problem, field=table.part or None)
        names.add(table.name)


def _recordings(data: SourceData, sieves: Iterable[Sieve]) -> pd.DataFrame:
    return pd.concat(
        sieve.rows.assign(recording_id=f"{data.description.name}/{table.name}")
        for table, sieve in zip(data.tables, sieves, strict=True)
    )[list(RECORDINGS.columns)]


def _launches(data: SourceData, sieves: Iterable[Sieve]) -> pd.DataFrame:
    prefixes = [f"{data.description.name}/{table.name}/" for table in data.tables]
    return pd.concat(
        sieve.rows.assign(launch_id=prefix + sieve.rows["id"].astype(str))
        for prefix, sieve in zip(prefixes, sieves, strict=True)
    )[list(LAUNCHES.columns)]


def _check_files(tables: Sequence[RawTable], sieves: Sequence[Sieve]) -> None:
    """Raise if nothing in a file can be used: then it is not what the source takes it for."""
    refused: dict[SourceFile | None, list[Refusal]] = defaultdict(list)
    useful: set[SourceFile | None] = {None}
    for table, sieve in zip(tables, sieves, strict=True):
        refused[table.file] += sieve.refusals
        if len(sieve.rows) or any(entry.reason == ONLY_SAMPLE for entry in sieve.refusals):
            useful.add(table.file)
    for file, refusals in refused.items():
        if file is None or file in useful:
            continue
        if not refusals:
            raise InputError(file.path, "holds no rows")
        problem = f"nothing in it can be used: {refusals[0].reason}"
        raise InputError(file.path, problem, row=refusals[0].row)


def _file_records(data: SourceData) -> list[FileRecord]:
    files = [*data.side_files, *(table.file for table in data.tables if table.file is not None)]
    return [FileRecord(file=str(file), sha256=file.sha256()) for file in dict.fromkeys(files)]


def _rate(recordings: pd.DataFrame) -> float:
    steps = recordings.groupby("recording_id", sort=False)["t"].diff()
    return round(1 / float(steps.median()), 2)


def _empty(contract: DataFrameSchema) -> pd.DataFrame:
    types = {name: column.dtype.type for name, column in contract.columns.items()}
    return pd.DataFrame(columns=list(types)).astype(types)
