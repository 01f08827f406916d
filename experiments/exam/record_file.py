"""The file of exam records: one JSON object a line."""

from collections.abc import Sequence
from pathlib import Path

from pydantic import ValidationError

from experiments.exam.records import ExamRecord
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.runtime.errors import InputError

RECORDS = Path("reports") / "exam" / "records.jsonl"  # of the whole exam, in the repository


def write_records(path: Path, records: Sequence[ExamRecord]) -> None:
    """Write records, one a line."""
    lines = (record.model_dump_json(exclude_defaults=True) for record in records)
    write_text(path, "".join(f"{line}\n" for line in lines))


def read_records(path: Path) -> list[ExamRecord]:
    """Read records that ``write_records`` wrote.

    Raises:
        InputError: there is no such file, it is empty, or a line of it is not a record.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        raise InputError(
            path, "there is no such file; run `python -m experiments.stages.exam`"
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, f"cannot be read as text: {error}") from None
    if not lines:
        raise InputError(path, "has no record; run `python -m experiments.stages.exam`")
    records = []
    for row, line in enumerate(lines, start=1):
        try:
            records.append(ExamRecord.model_validate_json(line))
        except ValidationError as error:
            first = error.errors()[0]
            field = ".".join(str(part) for part in first["loc"]) or None
            problem = f"{first['msg']}; run `python -m experiments.stages.exam`"
            raise InputError(path, problem, row=row, field=field) from None
    return records
