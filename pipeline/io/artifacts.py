"""Artefacts in and out: written whole or not at all, and byte-identical for identical content."""

import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
import pandas as pd
import pyarrow as pa
from pyarrow.parquet import ParquetFile, ParquetWriter
from pydantic import TypeAdapter, ValidationError

from rallygap.pipeline.runtime.errors import InputError

Content = TypeVar("Content")

COMPRESSION: Literal["zstd"] = "zstd"  # of tables


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path that takes the place of file ``path`` when the block succeeds.

    A block that fails leaves ``path`` unchanged and no other file.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
        temporary = Path(folder) / path.name
        yield temporary
        temporary.replace(path)


@contextmanager
def replacing_folder(path: Path) -> Iterator[Path]:
    """Yield an empty folder that takes the place of folder ``path`` when the block succeeds."""
    with replacing(path) as temporary:
        temporary.mkdir()
        yield temporary
        if path.exists():
            path.rename(temporary.parent / ".former")


@contextmanager
def replacing_files(out: Path, former: Sequence[str] = ()) -> Iterator[Path]:
    """Yield an empty folder whose files replace those of ``out`` when the block succeeds.

    Other files of ``out`` stay.

    Args:
        out: a folder; it is made if there is none.
        former: files of ``out`` that go even if no file replaces them.

    Raises:
        InputError: the folder cannot be written to.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out, prefix=".rallygap.") as folder:
            yield Path(folder)
            for name in former:
                (out / name).unlink(missing_ok=True)
            for path in sorted(Path(folder).rglob("*.*")):
                place = out / path.relative_to(folder)
                place.parent.mkdir(exist_ok=True)
                path.replace(place)
    except OSError as error:
        raise InputError(out, f"cannot be written to: {error.strerror}") from None


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text with Unix line ends."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def write_json(path: Path, content: Any) -> None:
    """Write JSON, indented, in the order given; not-a-number is an error rather than bad JSON."""

    def plain(value: Any) -> Any:
        if isinstance(value, np.generic):
            return value.item()
        raise TypeError(f"{type(value).__name__} cannot be written as JSON")

    write_text(path, json.dumps(content, indent=2, allow_nan=False, default=plain) + "\n")


def read_json(path: Path) -> Any:
    """Read a JSON file; a missing or broken one is an ``InputError``."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(path, "there is no such file; run the stage that writes it") from None
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(path, f"is not JSON: {error}") from None


def read_as(path: Path, schema: type[Content], stage: str = "", *, advice: str = "") -> Content:
    """Read a JSON file as a pydantic model or a list of them.

    Args:
        path: of the file.
        schema: of its content.
        stage: that writes it.
        advice: what to do about a broken file; by default to run ``stage`` again.

    Raises:
        InputError: the file is missing, or breaks the schema; naming the field.
    """
    try:
        return TypeAdapter(schema).validate_python(read_json(path))
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        advice = advice or f"run `dvc repro -f {stage}` to write it again"
        raise InputError(path, f"{first['msg']}; {advice}", field=field) from None


def write_table(path: Path, table: pd.DataFrame) -> None:
    """Write a table as parquet (zstd); same table, same bytes."""
    with replacing(path) as temporary:
        table.to_parquet(temporary, index=False, compression=COMPRESSION)


def write_csv(path: Path, table: pd.DataFrame, digits: int = 6) -> None:
    """Write a table as csv, so many significant digits a number; same table, same bytes."""
    with replacing(path) as temporary:
        table.to_csv(temporary, index=False, float_format=f"%.{digits}g", lineterminator="\n")


@contextmanager
def table_writer(path: Path, empty: pd.DataFrame) -> Iterator[Callable[[pd.DataFrame], None]]:
    """Yield a function that adds rows to a table that need not fit into memory.

    Every call writes one row group, which ``read_row_groups`` gives back. The table takes its place
    when the block succeeds.

    Args:
        path: of the table.
        empty: a table without rows; those that follow have its columns and types.
    """
    schema = pa.Schema.from_pandas(empty, preserve_index=False)
    with (
        replacing(path) as temporary,
        ParquetWriter(temporary, schema, compression=COMPRESSION) as writer,
    ):

        def add(rows: pd.DataFrame) -> None:
            if len(rows):
                group = pa.Table.from_pandas(rows, schema, preserve_index=False)
                writer.write_table(group, row_group_size=len(rows))

        yield add


@contextmanager
def open_table(path: Path) -> Iterator[ParquetFile]:
    """Open a parquet table, to read parts of it.

    Raises:
        InputError: it is missing or broken; also where this shows only when a part is read.
    """
    try:
        with ParquetFile(path) as table:
            yield table
    except FileNotFoundError:
        raise InputError(path, "there is no such table; run the stage that writes it") from None
    except (OSError, ValueError, KeyError, TypeError, NotImplementedError, MemoryError) as error:
        reason = " ".join(str(error).split())
        raise InputError(path, f"is not a parquet table: {reason}") from None


def read_table(path: Path, columns: list[str] | None = None) -> pd.DataFrame:
    """Read a parquet table, or some columns of it; a missing or broken one is an ``InputError``."""
    with open_table(path) as table:
        return table.read(columns).to_pandas()


def read_row_groups(path: Path) -> Iterator[pd.DataFrame]:
    """Yield a parquet table in the parts it was written in, one in memory at a time.

    A missing or broken one is an ``InputError``.
    """
    with open_table(path) as table:
        for number in range(table.num_row_groups):
            yield table.read_row_group(number).to_pandas()
