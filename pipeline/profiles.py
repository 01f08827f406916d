"""Profiles: files that hold only the parameters that differ from params.yaml.

A profile becomes ``-S key=value`` flags for ``dvc exp run``, so that params.yaml stays the file
that people edit.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rallygap.models.support.suggestion import suggestion
from rallygap.pipeline.params import Params, check_params, load_params, read_yaml
from rallygap.pipeline.runtime.errors import InputError


def profile_flags(root: Path, name: str) -> list[str]:
    """The flags that turn params.yaml into a profile.

    Args:
        root: the repository, with params.yaml and the folder experiments/profiles.
        name: the profile, as the file ``experiments/profiles/<name>.yaml``.

    Raises:
        InputError: there is no such profile, or it does not fit params.yaml.
    """
    changed, _ = _read(root, name)
    return flags(read_yaml(root / "params.yaml"), changed)


def profile_params(root: Path, name: str) -> Params:
    """The parameters of a profile; arguments and errors as of ``profile_flags``."""
    _, params = _read(root, name)
    return params


def _read(root: Path, name: str) -> tuple[Any, Params]:
    """The content of params.yaml with a profile laid over it, and the same as parameters."""
    path = root / "experiments" / "profiles" / f"{name}.yaml"
    if not path.is_file():
        names = [file.stem for file in path.parent.glob("*.yaml")]
        raise InputError(path, f"there is no such profile; {suggestion(name, names)}")
    load_params(root / "params.yaml")
    changed = merged(read_yaml(root / "params.yaml"), read_yaml(path) or {})
    return changed, check_params(changed, path)


def merged(params: Any, changes: Any) -> Any:
    """``params`` with ``changes`` laid over it, key by key."""
    if not (isinstance(params, dict) and isinstance(changes, dict)):
        return changes
    both = {key: merged(params.get(key), value) for key, value in changes.items()}
    return {**params, **both}


def flags(params: dict[str, Any], changed: dict[str, Any]) -> list[str]:
    """The ``dvc exp run`` flags that turn ``params`` into ``changed``.

    No flag has white space in it, so that a shell passes ``$(rallygap profile ...)`` on unharmed.
    """
    return [word for override in _overrides(params, changed, "") for word in ("-S", override)]


def _overrides(params: dict[str, Any], changed: dict[str, Any], above: str) -> Iterator[str]:
    """Differences in Hydra's grammar: ``key=value``, ``+key=value`` for a new key, ``~key``."""
    yield from (f"~{above}{key}" for key in params if key not in changed)
    for key, value in changed.items():
        old, name = params.get(key), f"{above}{key}"
        if isinstance(value, dict):
            yield from _overrides(old if isinstance(old, dict) else {}, value, f"{name}.")
        elif key not in params:
            yield f"+{name}={_written(name, value)}"
        elif value != old:
            yield f"{name}={_written(name, value)}"


def _written(key: str, value: Any) -> str:
    """JSON, which Hydra's grammar takes for values other than dictionaries."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    if "\\" in text or any(character.isspace() for character in text):
        problem = "holds white space, a quote or a backslash, which a shell would not pass on"
        raise InputError("parameters", problem, field=key)
    return text
