"""Parameters and metrics as MLflow takes them: flat."""

import json
import os
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rallygap.models.support.yaml_file import parse_yaml
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.runtime.git import git


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


def changed_params(home: Path) -> dict[str, str]:
    """Parameters of the working directory that differ from those of the commit, by dotted key.

    Args:
        home: the repository, which DVC's temporary copies have no git history of.
    """
    revision = os.environ.get("DVC_EXP_BASELINE_REV", "HEAD")
    committed, path = git(home, "show", f"{revision}:params.yaml"), Path("params.yaml")
    if committed is None or not path.exists():
        return {}
    before, after = dotted(parse_yaml(committed)), dotted(read_yaml(path))
    changed = sorted(key for key in before.keys() | after if before.get(key) != after.get(key))
    return {key: after.get(key, "absent") for key in changed}


def flat_metrics(metrics: dict[str, Any]) -> dict[int, dict[str, float]]:
    """The numbers among nested metrics, by step and name; a level of whole numbers is the step.

    ``{"position": {"100": {"mean": 3.0}}}`` is ``position/mean`` at step 100, and MLflow draws
    the error over the horizon.
    """
    by_step: dict[int, dict[str, float]] = defaultdict(dict)
    for keys, value in flat(metrics):
        if isinstance(value, int | float):
            steps = [int(key) for key in keys if key.isdecimal()]
            name = "/".join(key for key in keys if not key.isdecimal())
            by_step[steps[-1] if steps else 0][name] = value
    return by_step


def reported_metrics() -> dict[str, float]:
    """The metrics of all stages of ./dvc.yaml, each named after its stage; not of experiments.

    DVC may have taken a stage from its cache, so that it has no run of its own.
    """
    stages = sorted(read_yaml(Path("dvc.yaml"))["stages"])
    files = {stage: Path("reports") / stage / "metrics.json" for stage in stages}
    metrics = {stage: read_json(file) for stage, file in files.items() if file.exists()}
    named = {"/".join(keys): value for keys, value in flat(metrics)}
    return {name: value for name, value in named.items() if isinstance(value, int | float)}
