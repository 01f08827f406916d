"""Which parameters of a run differ from those of the commit that it started from."""

import json
import os
import re
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from models.support.yaml_file import parse_yaml
from pipeline.params import read_yaml

LONGEST_VALUE = 250  # characters of a parameter that every MLflow store takes


@dataclass(frozen=True)
class Change:
    """A parameter's value in the commit and in the run, as text."""

    committed: str
    here: str

    def __str__(self) -> str:
        return shortened(f"{self.here} (committed: {self.committed})")


def changed_params(home: Path) -> dict[str, Change]:
    """Compare params.yaml in the working directory with that of the commit.

    Args:
        home: the repository, which DVC's temporary copies have no git history of.

    Returns:
        The differences by dotted key; none where there is no such commit.
    """
    revision = os.environ.get("DVC_EXP_BASELINE_REV", "HEAD")
    command = ["git", "show", f"{revision}:params.yaml"]
    shown = subprocess.run(command, cwd=home, capture_output=True, text=True, check=False)
    path = Path("params.yaml")
    if shown.returncode != 0 or not path.exists():
        return {}
    before, after = _texts(parse_yaml(shown.stdout)), _texts(read_yaml(path))
    return {
        key: Change(before.get(key, "absent"), after.get(key, "absent"))
        for key in sorted(before.keys() | after)
        if before.get(key) != after.get(key)
    }


def flat(values: dict[str, Any], *above: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """The leaves of a nested dictionary, each with the keys to it in characters MLflow allows."""
    for key, value in values.items():
        keys = (*above, re.sub(r"[^\w.: -]", "_", str(key)))
        if isinstance(value, dict):
            yield from flat(value, *keys)
        else:
            yield keys, value


def shortened(value: Any) -> str:
    """A parameter as text, cut where a store would cut or refuse it."""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 1] + "…"


def _texts(params: dict[str, Any]) -> dict[str, str]:
    return {".".join(keys): shortened(value) for keys, value in flat(params)}
