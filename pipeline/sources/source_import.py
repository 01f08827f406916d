"""The import of one source: its rows in batches, the impossible ones refused, and the record."""

import hashlib
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.io.schemas import (
    FARTHEST_POSITION,
    FASTEST_BALL,
    FASTEST_SPIN,
    LAUNCHES,
    POSITION_COLUMNS,
    RECORDINGS,
    SPIN_COLUMNS,
    VELOCITY_COLUMNS,
)
from rallygap.pipeline.io.source_manifest import FileRecord, Refused, SourceRecord
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.source import (
    LAUNCH_COLUMNS,
    SAMPLE_COLUMNS,
    RawTable,
    Refusal,
    SourceData,
)

BATCH_ROWS = 200_000  # that are checked and written at once, at least
SHORTEST_STEP = 1e-6  # s, between two samples
ONLY_SAMPLE = "the only sample of its recording"


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


class RowChecks:
    """Rows and labels of some tables, of which the impossible ones are refused.

    Attributes:
        rows: in the table frame, of all tables in their order; column ``table`` is the number of
            the table.
        refusals: by checks and by the reader.
    """

    def __init__(self, tables: Sequence[RawTable], frame: Frame, *, launches: bool) -> None:
        """Transform recordings or launches into the table frame, and check them."""
        columns = LAUNCH_COLUMNS if launches else SAMPLE_COLUMNS
        self._places = [table.place for table in tables]
        self.refusals = [refusal for table in tables for refusal in table.refusals]
        rows = pd.concat([table.rows for table in tables], ignore_index=True)
        numbers = dict.fromkeys([name for name in columns if name != "id"], float)
        self.rows = rows.reindex(columns=["row", *columns]).astype(numbers)
        lengths = [len(table.rows) for table in tables]
        self.rows.insert(0, "table", np.repeat(np.arange(len(tables)), lengths))
        needed = [*POSITION_COLUMNS, *VELOCITY_COLUMNS] if launches else ["t", *POSITION_COLUMNS]
        finite = np.isfinite(self.rows[needed].to_numpy(dtype=float)).all(axis=1)
        self._refuse("not a number", pd.Series(~finite, index=self.rows.index))
        known = self.rows[SPIN_COLUMNS].notna()
        self._refuse("spin incomplete", known.any(axis=1) & ~known.all(axis=1), "label")
        too_fast = self._longer(SPIN_COLUMNS, FASTEST_SPIN)
        self._refuse(f"spin above {FASTEST_SPIN:g} rad/s", too_fast, "label")
        self.rows = frame.to_table(self.rows)
        far = (self.rows[POSITION_COLUMNS].abs() > FARTHEST_POSITION).any(axis=1)
        self._refuse(f"farther than {FARTHEST_POSITION:g} m", far)
        if launches:
            too_fast = self._longer(VELOCITY_COLUMNS, FASTEST_BALL)
            self._refuse(f"faster than {FASTEST_BALL:g} m/s", too_fast)
            self._refuse("id repeated", self.rows.duplicated(["table", "id"]))
        else:
            self._check_times()

    def _check_times(self) -> None:
        """Refuse samples that are not later than every previous one of their recording."""
        latest = self.rows.groupby("table")["t"].cummax()
        step = self.rows["t"] - latest.groupby(self.rows["table"]).shift()
        self._refuse("time backwards", step < 0)
        self._refuse("time repeated", step[self.rows.index] < SHORTEST_STEP)
        samples = self.rows.groupby("table")["t"].transform("size")
        self._refuse(ONLY_SAMPLE, samples == 1)

    def _refuse(
        self, reason: str, at_fault: "pd.Series[bool]", what: Literal["row", "label"] = "row"
    ) -> None:
        """Remove rows, or the spin of rows."""
        faulty = self.rows[at_fault]
        for table, row in zip(faulty["table"], faulty["row"], strict=True):
            self.refusals.append(Refusal(self._places[table], int(row), reason, what))
        if what == "row":
            self.rows = self.rows[~at_fault]
        else:
            self.rows.loc[at_fault, SPIN_COLUMNS] = np.nan

    def _longer(self, columns: list[str], limit: float) -> "pd.Series[bool]":
        """Return the rows in which the vector in ``columns`` is longer than ``limit``."""
        with np.errstate(over="ignore"):  # an overflow is too long, too
            length = np.linalg.norm(self.rows[columns].to_numpy(dtype=float), axis=1)
        return pd.Series(length > limit, index=self.rows.index)


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
        for table in batch:
            if table.name in self._names:
                where = table.file or self._description.name
                problem = f"there is another recording {table.name}"
                raise InputError(where, problem, field=table.part or None)
            self._names.add(table.name)
        checks = RowChecks(batch, self._description.frame, launches=self.is_launches)
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
        rate = None
        if not self.is_launches:
            rate = round(1 / float(np.median(np.concatenate(self._steps))), 2)
        return SourceRecord(
            **dict(self._description),
            rate_hz=rate,
            recordings=self._recordings,
            launches=self._rows_kept if self.is_launches else 0,
            rows_read=self._rows_read,
            rows_kept=self._rows_kept,
            rows_refused=_by_reason(entry for entry in self._refusals if entry.what == "row"),
            labels_refused=_by_reason(entry for entry in self._refusals if entry.what == "label"),
            files=[FileRecord(file=path.name, sha256=_sha256(path)) for path in files],
        )

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
        for path, usable in self._files.items():
            for refusal in self._refusals if not usable else []:
                if refusal.place.split("/")[0] == path.name:
                    problem = f"nothing in it can be used: {refusal.reason}"
                    raise InputError(path, problem, row=refusal.row)
            if not usable:
                raise InputError(path, "holds no rows")


def _by_reason(refusals: Iterable[Refusal]) -> dict[str, Refused]:
    """Return refusals counted by reason, with their rows by place, in a fixed order."""
    groups: dict[str, list[Refusal]] = defaultdict(list)
    for refusal in refusals:
        groups[refusal.reason].append(refusal)
    refused = {}
    for reason, group in sorted(groups.items()):
        rows: dict[str, list[int]] = defaultdict(list)
        for refusal in sorted(group):
            rows[refusal.place].append(refusal.row)
        refused[reason] = Refused(count=len(group), rows=dict(rows))
    return refused


def _sha256(path: Path) -> str:
    with path.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
