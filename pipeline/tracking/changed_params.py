"""Which parameters of a run differ from those of the commit that it started from."""

import json
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from rallygap.models.support.yaml_file import parse_yaml
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.runtime.git import git_if_known


class Change(NamedTuple):
    """A parameter's value in the commit and in the run, as text."""

    committed: str
    here: str

    def __str__(self) -> str:
        return f"{self.here} (committed: {self.committed})"


def changed_params(home: Path) -> dict[str, Change]:
    """Compare params.yaml in the working directory with that of the commit.

    Args:
        home: the repository, which DVC's temporary copies have no git history of.

    Returns:
        The differences by dotted key; none where there is no such commit.
    """
    revision = os.environ.get("DVC_EXP_BASELINE_REV", "HEAD")
    committed, path = git_if_known(home, "show", f"{revision}:params.yaml"), Path("params.yaml")
    if committed is None or not path.exists():
        return {}
    before, after = dotted(parse_yaml(committed)), dotted(read_yaml(path))
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


def dotted(params: dict[str, Any]) -> dict[str, str]:
    """Nested parameters as text by dotted key; MLflow cuts what is too long for its store."""
    return {
        ".".join(keys): value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
        for keys, value in flat(params)
    }
