"""The import of one source: its rows in batches, checked, and the record of what was refused."""

import hashlib
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rallygap.pipeline.io.schemas import LAUNCHES, RECORDINGS
from rallygap.pipeline.io.source_manifest import FileRecord, Refused, SourceRecord
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.row_checks import (
    ONLY_SAMPLE,
    RowChecks,
    check_launches,
    check_samples,
)
from rallygap.pipeline.sources.source import RawTable, Refusal, SourceData

BATCH_ROWS = 200_000  # that are checked and written at once, at least


def in_batches(tables: Iterable[RawTable]) -> Iterator[list[RawTable]]:
    """Yield tables in groups of at least ``BATCH_ROWS`` rows; the last may have fewer."""
    batch: list[RawTable] = []
    rows = 0
    for table in tables:
        batch.append(table)
        rows += len(table.rows)
        if rows >= BATCH_ROWS:
            yield batch
            batch, rows = [], 0
    if batch:
        yield batch


class SourceImport:
    """Checks the tables of a source, batch by batch, and records what it refuses."""

    def __init__(self, data: SourceData) -> None:
        self._description = data.description
        self._side_files = data.side_files
        self._refusals = list(data.refusals)
        self._names: set[str] = set()
        self._files: dict[Path, bool] = {}  # whether anything in the file is usable
        self._steps: list[NDArray[np.float64]] = []
        self._rows_read = self._rows_kept = self._recordings = 0

    @property
    def is_launches(self) -> bool:
        """Whether the source has states without a path."""
        return self._description.kind == "launches"

    @property
    def folder(self) -> Path | None:
        """The folder of the files read so far; ``None`` if there were none."""
        return next((path.parent for path in self._files), None)

    def rows(self, batch: Sequence[RawTable]) -> pd.DataFrame:
        """Return the possible rows of a batch, in the columns of ``LAUNCHES`` or ``RECORDINGS``.

        Raises:
            InputError: two recordings of the source have the same name.
        """
        self._check_names(batch)
        check = check_launches if self.is_launches else check_samples
        checks = check(batch, self._description.frame)
        self._count(batch, checks)
        names = [f"{self._description.name}/{table.name}" for table in batch]
        ids = pd.Series(names, dtype="str").take(checks.rows["table"].to_numpy())
        ids.index = checks.rows.index
        if self.is_launches:
            ids += "/" + checks.rows["id"].astype("str")
            return checks.rows.assign(launch_id=ids)[list(LAUNCHES.columns)]
        return checks.rows.assign(recording_id=ids)[list(RECORDINGS.columns)]

    def record(self) -> SourceRecord:
        """Return the source's entry in the manifest, after the last batch.

        Raises:
            InputError: there is no recording, or a file as a whole is not what the source reads.
        """
        self._check_files()
        if not self._names:
            raise InputError(self._description.name, "holds no recording")
        if not self._rows_kept:
            raise InputError(self._description.name, "no recording has more than one sample")
        files = dict.fromkeys([*self._side_files, *self._files])
        return SourceRecord(
            **dict(self._description),
            rate_hz=None if self.is_launches else self._rate(),
            recordings=self._recordings,
            launches=self._rows_kept if self.is_launches else 0,
            rows_read=self._rows_read,
            rows_kept=self._rows_kept,
            rows_refused=_by_reason(entry for entry in self._refusals if entry.what == "row"),
            labels_refused=_by_reason(entry for entry in self._refusals if entry.what == "label"),
            files=[FileRecord(file=path.name, sha256=_sha256(path)) for path in files],
        )

    def _check_names(self, batch: Sequence[RawTable]) -> None:
        for table in batch:
            if table.name in self._names:
                where = table.file or self._description.name
                problem = f"there is another recording {table.name}"
                raise InputError(where, problem, field=table.part or None)
            self._names.add(table.name)

    def _count(self, batch: Sequence[RawTable], checks: RowChecks) -> None:
        self._refusals += checks.refusals
        self._rows_read += sum(len(table.rows) + len(table.refusals) for table in batch)
        self._rows_kept += len(checks.rows)
        kept = np.bincount(checks.rows["table"], minlength=len(batch))
        single = {refusal.place for refusal in checks.refusals if refusal.reason == ONLY_SAMPLE}
        for table, rows in zip(batch, kept, strict=True):
            if table.file is not None:
                usable = bool(rows) or table.place in single
                self._files[table.file] = usable or self._files.get(table.file, False)
        if not self.is_launches:
            self._recordings += checks.rows["table"].nunique()
            steps = checks.rows.groupby("table")["t"].diff().dropna()
            self._steps.append(steps.to_numpy())

    def _check_files(self) -> None:
        """Raise if a file has no usable row: then it is not what the source reads."""
        for path in [path for path, usable in self._files.items() if not usable]:
            of_file = (one for one in self._refusals if one.place.split("/")[0] == path.name)
            refusal = next(of_file, None)
            if refusal is None:
                raise InputError(path, "holds no rows")
            problem = f"nothing in it can be used: {refusal.reason}"
            raise InputError(path, problem, row=refusal.row)

    def _rate(self) -> float:
        return round(1 / float(np.median(np.concatenate(self._steps))), 2)


def _by_reason(refusals: Iterable[Refusal]) -> dict[str, Refused]:
    """Return refusals counted by reason, with their rows by place, in a fixed order."""
    groups: dict[str, list[Refusal]] = defaultdict(list)
    for refusal in refusals:
        groups[refusal.reason].append(refusal)
    return {reason: _refused(groups[reason]) for reason in sorted(groups)}


def _refused(refusals: list[Refusal]) -> Refused:
    rows: dict[str, list[int]] = defaultdict(list)
    for refusal in sorted(refusals):
        rows[refusal.place].append(refusal.row)
    return Refused(count=len(refusals), rows=dict(rows))


def _sha256(path: Path) -> str:
    with path.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
