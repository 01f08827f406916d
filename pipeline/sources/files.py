"""The files of a source: found in a fixed order, read as text or not at all."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from pipeline.runtime.errors import InputError


@dataclass(frozen=True)
class SourceFile:
    """One file of a source."""

    path: Path

    def __str__(self) -> str:
        return self.path.name

    @property
    def stem(self) -> str:
        """The name without its ending."""
        return self.path.stem

    def sha256(self) -> str:
        """Return the checksum of the content, in hexadecimal."""
        with self.path.open("rb") as content:
            return hashlib.file_digest(content, "sha256").hexdigest()

    def text(self) -> str:
        """Return the content as UTF-8 text; a byte order mark is left out.

        Raises:
            InputError: the file cannot be read, or is no text.
        """
        try:
            return self.path.read_text(encoding="utf-8-sig")
        except UnicodeDecodeError:
            raise InputError(self.path, "is not UTF-8 text; is it what its name says?") from None
        except OSError as error:
            raise InputError(self.path, f"cannot be read: {error.strerror}") from None


def source_file(folder: Path, name: str) -> SourceFile:
    """Return the file ``name`` of a source.

    Raises:
        InputError: there is no such file.
    """
    if not (folder / name).is_file():
        raise InputError(folder / name, "there is no such file, and the source needs it")
    return SourceFile(folder / name)


def source_files(folder: Path, pattern: str) -> list[SourceFile]:
    """Return the files of a source whose names match ``pattern``, by name.

    Raises:
        InputError: there is none, or a name cannot be part of a recording's id.
    """
    paths = sorted(
        path for path in folder.glob(pattern) if path.is_file() and not path.name.startswith(".")
    )
    if not paths:
        raise InputError(folder, f"holds no file {pattern}")
    for path in paths:
        if not path.name.isprintable():
            raise InputError(folder, f"file name {path.name!a} has unprintable characters")
    return [SourceFile(path) for path in paths]
