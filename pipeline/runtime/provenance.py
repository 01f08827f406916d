"""Where a stage's results come from: its command and a fingerprint of all it depends on."""

import hashlib
import json
import os
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pathspec import PathSpec
from pathspec.util import RecursionError as LinkLoopError

from pipeline.params import read_yaml
from pipeline.runtime.errors import InputError

SHOWN = 12  # characters
NOTHING = PathSpec.from_lines("gitignore", [])


@dataclass(frozen=True)
class Provenance:
    """The run of a stage, as DVC knows it."""

    command: str
    fingerprint: str
    """SHA-256 over the command, the parameters and the content of the dependencies. It is the
    name under which DVC's run cache files the run, and follows from the entry in dvc.lock."""


def provenance(root: Path, stage: str) -> Provenance:
    """Describe the run of a stage of ``root/dvc.yaml`` with its dependencies as they are now."""
    entry = read_yaml(root / "dvc.yaml")["stages"][stage]
    values = read_yaml(root / "params.yaml")
    ignored = _ignored(root)
    return Provenance(
        entry["cmd"],
        run_cache_key(
            entry["cmd"],
            {path: content_hash(root / path, ignored) for path in entry["deps"]},
            {key: values[key] for key in entry["params"]},
            [path if isinstance(path, str) else next(iter(path)) for path in entry["outs"]],
        ),
    )


def short(fingerprint: str) -> str:
    """The beginning of a fingerprint, enough for a name."""
    return fingerprint[:SHOWN]


def run_cache_key(
    command: str, dependencies: dict[str, str], params: dict[str, Any], outputs: Iterable[str]
) -> str:
    """The key of a stage in DVC's run cache.

    Args:
        command: the stage's command.
        dependencies: path to MD5 of the content.
        params: the parameters that the stage lists.
        outputs: the paths that it writes.
    """
    identity = {
        "cmd": command,
        "deps": [
            {"path": path, "hash": "md5", "md5": digest}
            for path, digest in sorted(dependencies.items())
        ],
        "params": {"params.yaml": params},
        "outs": sorted(outputs),
    }
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()


def content_hash(path: Path, ignored: PathSpec = NOTHING) -> str:
    """MD5 of a file or of all files in a folder but the ignored, by DVC's rules.

    Raises:
        InputError: there is no such file or folder, or it cannot be read, as where links loop.
    """
    if path.is_file():
        return _file_hash(path)
    if not path.is_dir():
        raise InputError(path, "is missing; `dvc repro` runs the stage that writes it")
    try:
        files = (path / name for name in ignored.match_tree_files(path, negate=True))
        relative = {file.relative_to(path).as_posix(): file for file in files}
        listing = [
            {"md5": _file_hash(file), "relpath": name} for name, file in sorted(relative.items())
        ]
    except LinkLoopError as error:
        raise InputError(path, f"has links that loop: {error.message}") from None
    except OSError as error:
        raise InputError(
            Path(error.filename or path), f"cannot be read: {error.strerror}"
        ) from None
    return hashlib.md5(json.dumps(listing, sort_keys=True).encode()).hexdigest() + ".dir"


def repository_root() -> Path:
    """The repository, whatever the working directory.

    DVC runs an experiment in a temporary copy of the repository and names the real one in DVC_ROOT.
    Elsewhere it is the nearest folder that holds pyproject.toml, or else the working directory.
    """
    if "DVC_ROOT" in os.environ:
        return Path(os.environ["DVC_ROOT"])
    here = Path.cwd()
    homes = (home for home in (here, *here.parents) if (home / "pyproject.toml").is_file())
    return next(homes, here)


def git_commit(root: Path) -> str | None:
    """The commit that is checked out, or None outside git."""
    command = ["git", "rev-parse", "--verify", "--quiet", "HEAD"]
    found = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    return found.stdout.strip() or None


def _ignored(root: Path) -> PathSpec:
    path = root / ".dvcignore"
    return (
        PathSpec.from_lines("gitignore", path.read_text().splitlines())
        if path.exists()
        else NOTHING
    )


def _file_hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "md5").hexdigest()
