"""What is taken over from one source, batch by batch, and the record of the rest."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.io.schemas import LAUNCHES, RECORDINGS
from pipeline.runtime.errors import InputError
from pipeline.sources.files import SourceFile
from pipeline.sources.manifest import FileRecord, SourceRecord, by_reason
from pipeline.sources.sieve import ONLY_SAMPLE, Sieve, sift_launches, sift_samples
from pipeline.sources.source import RawTable, Refusal, SourceData

BATCH_ROWS = 200_000  # at least so many go through the sieve and into the table at once


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


class Intake:
    """Takes a source over, one batch of tables after the other."""

    def __init__(self, data: SourceData) -> None:
        self._description = data.description
        self._refusals = list(data.refusals)
        self._names: set[str] = set()
        self._side_files = data.side_files
        self._files: dict[SourceFile, list[Refusal]] = {}
        self._useful: set[SourceFile] = set()
        self._steps: list[NDArray[np.float64]] = []
        self._rows_read = self._rows_kept = self._recordings = 0

    @property
    def is_launches(self) -> bool:
        """Whether the source has states without a path."""
        return self._description.kind == "launches"

    @property
    def folder(self) -> Path | None:
        """The folder of the files read so far; ``None`` if there were none."""
        return next((file.path.parent for file in self._files), None)

    def take(self, batch: Sequence[RawTable]) -> pd.DataFrame:
        """Return what of a batch can be, as rows of ``LAUNCHES`` or ``RECORDINGS``.

        Raises:
            InputError: two recordings of the source have the same name.
        """
        self._check_names(batch)
        sift = sift_launches if self.is_launches else sift_samples
        sieve = sift(batch, self._description.frame)
        self._count(batch, sieve)
        names = [f"{self._description.name}/{table.name}" for table in batch]
        ids = pd.Series(names, dtype="str").take(sieve.rows["table"].to_numpy())
        ids.index = sieve.rows.index
        if self.is_launches:
            ids += "/" + sieve.rows["id"].astype("str")
            return sieve.rows.assign(launch_id=ids)[list(LAUNCHES.columns)]
        return sieve.rows.assign(recording_id=ids)[list(RECORDINGS.columns)]

    def record(self) -> SourceRecord:
        """Return what was read and what was refused, when every batch has been taken.

        Raises:
            InputError: nothing came, or a file as a whole is not what the source takes it for.
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
            rows_refused=by_reason(entry for entry in self._refusals if entry.what == "row"),
            labels_refused=by_reason(entry for entry in self._refusals if entry.what == "label"),
            files=[FileRecord(file=str(file), sha256=file.sha256()) for file in files],
        )

    def _check_names(self, batch: Sequence[RawTable]) -> None:
        for table in batch:
            if table.name in self._names:
                where = table.file.path if table.file else self._description.name
                problem = f"a recording {table.name} was there before"
                raise InputError(where, problem, field=table.part or None)
            self._names.add(table.name)

    def _count(self, batch: Sequence[RawTable], sieve: Sieve) -> None:
        self._refusals += sieve.refusals
        self._rows_read += sum(len(table.rows) + len(table.refusals) for table in batch)
        self._rows_kept += len(sieve.rows)
        self._note_files(batch, sieve)
        if not self.is_launches:
            self._recordings += sieve.rows["table"].nunique()
            steps = sieve.rows.groupby("table")["t"].diff().dropna()
            self._steps.append(steps.to_numpy())

    def _note_files(self, batch: Sequence[RawTable], sieve: Sieve) -> None:
        """Note of every file what was refused, and whether anything in it is a ball."""
        kept = np.bincount(sieve.rows["table"], minlength=len(batch))
        refused = _by_place(sieve.refusals)
        for table, rows in zip(batch, kept, strict=True):
            if table.file is None:
                continue
            refusals = refused.get(table.place, [])
            self._files.setdefault(table.file, []).extend(refusals)
            if rows or any(refusal.reason == ONLY_SAMPLE for refusal in refusals):
                self._useful.add(table.file)

    def _check_files(self) -> None:
        """Raise if nothing in a file can be used: then it is not what the source takes it for."""
        for file, refusals in self._files.items():
            if file in self._useful:
                continue
            if not refusals:
                raise InputError(file.path, "holds no rows")
            problem = f"nothing in it can be used: {refusals[0].reason}"
            raise InputError(file.path, problem, row=refusals[0].row)

    def _rate(self) -> float:
        return round(1 / float(np.median(np.concatenate(self._steps))), 2)


def _by_place(refusals: Iterable[Refusal]) -> dict[str, list[Refusal]]:
    places: dict[str, list[Refusal]] = {}
    for refusal in refusals:
        places.setdefault(refusal.place, []).append(refusal)
    return places
