"""Where a stage's results come from: its command, the commit, and a fingerprint of its inputs."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.runtime.errors import InputError

SHOWN = 12  # characters
BYTECODE = {".pyc", ".nbi", ".nbc"}  # compiled from sources, so no input of its own


@dataclass(frozen=True)
class Provenance:
    """A stage's command, and SHA-256 over it, the parameters and the content of dependencies."""

    command: str
    fingerprint: str


def provenance(root: Path, stage: str) -> Provenance:
    """Describe the run of a stage of dvc.yaml with its dependencies as they are now.

    Raises:
        InputError: a dependency is missing or cannot be read.
    """
    pipelines = (root / "dvc.yaml", root / "experiments" / "dvc.yaml")
    stages = [read_yaml(path)["stages"] for path in pipelines if path.is_file()]
    entry = next(entries[stage] for entries in stages if stage in entries)
    values = read_yaml(root / "params.yaml")
    inputs = {
        "command": entry["cmd"],
        "params": {key: values[key] for key in entry.get("params", [])},
        "dependencies": {path: content_hash(root / path) for path in entry["deps"]},
    }
    digest = hashlib.sha256(json.dumps(inputs, sort_keys=True).encode())
    return Provenance(entry["cmd"], digest.hexdigest())


def short(fingerprint: str) -> str:
    """The first characters of a fingerprint, enough for a name."""
    return fingerprint[:SHOWN]


def content_hash(path: Path) -> str:
    """MD5 of a file, or of the names and contents of all files in a folder.

    Raises:
        InputError: there is no such file or folder, or it cannot be read.
    """
    try:
        if path.is_file():
            return _file_hash(path)
        if not path.is_dir():
            raise InputError(path, "is missing; `dvc repro` runs the stage that writes it")
        files = (file for file in path.rglob("*") if file.is_file() and file.suffix not in BYTECODE)
        contents = {file.relative_to(path).as_posix(): _file_hash(file) for file in files}
    except OSError as error:
        where = Path(error.filename or path)
        raise InputError(where, f"cannot be read: {error.strerror}") from None
    return hashlib.md5(json.dumps(contents, sort_keys=True).encode()).hexdigest()


def _file_hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "md5").hexdigest()
