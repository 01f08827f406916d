"""Artefacts in and out: written whole or not at all, and byte-identical for identical content."""

import json
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd
from pydantic import TypeAdapter, ValidationError

from pipeline.errors import InputError

Content = TypeVar("Content")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary file beside ``path`` that takes its place when the block succeeds.

    A block that fails leaves ``path`` as it was and nothing beside it.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
        temporary = Path(folder) / path.name
        yield temporary
        temporary.replace(path)


@contextmanager
def replacing_folder(path: Path) -> Iterator[Path]:
    """Yield an empty folder that takes the place of folder ``path`` when the block succeeds."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
        temporary = Path(folder) / path.name
        temporary.mkdir()
        yield temporary
        if path.exists():
            path.rename(Path(folder) / "former")
        temporary.rename(path)


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text with Unix line ends."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def write_json(path: Path, content: Any) -> None:
    """Write JSON, indented, in the order given; not-a-number is an error rather than bad JSON."""
    write_text(path, json.dumps(content, indent=2, allow_nan=False, default=_plain) + "\n")


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


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


def read_as(path: Path, schema: type[Content], stage: str) -> Content:
    """Read a JSON file that ``stage`` wrote, as a pydantic model or a list of them.

    Raises:
        InputError: the file is missing, or breaks the schema; naming the field and the stage.
    """
    try:
        return TypeAdapter(schema).validate_python(read_json(path))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        problem = f"{first['msg']}; run `dvc repro -f {stage}` to write it anew"
        raise InputError(path, problem, field=place) from None


def write_table(path: Path, table: pd.DataFrame) -> None:
    """Write a table as parquet (zstd); same table, same bytes."""
    with replacing(path) as temporary:
        table.to_parquet(temporary, index=False, compression="zstd")


def read_table(path: Path) -> pd.DataFrame:
    """Read a parquet table; a missing or broken one is an ``InputError``."""
    try:
        with path.open("rb") as content:
            return pd.read_parquet(content)
    except FileNotFoundError:
        raise InputError(path, "there is no such table; run the stage that writes it") from None
    except (OSError, ValueError) as error:
        raise InputError(path, f"is not a parquet table: {error}") from None
