"""The paper's numbers and claims: ``values.yaml``, read, with a row for every combination."""

import itertools
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import yaml

PATH = Path(__file__).with_name("values.yaml")


class PrintedTransfer(NamedTuple):
    """A set of the paper's Table I: its shots, and ``counts[horizons][predictor][outcome]``."""

    shots: int
    counts: Mapping[str, Mapping[str, Mapping[str, int]]]


@cache
def printed_values() -> Mapping[str, Any]:
    """Return the content of the file."""
    content: Mapping[str, Any] = yaml.safe_load(PATH.read_text(encoding="utf-8"))
    return content


def printed_transfer() -> dict[str, PrintedTransfer]:
    """Return the paper's Table I by set."""
    content = printed_values()
    return {
        name: PrintedTransfer(one["shots"], content["transfer"][name])
        for name, one in content["sets"].items()
    }


def group_rows(group: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the rows of a group with what they inherit, one for every combination of their axes."""
    for row in group["rows"]:
        own = {**group.get("rows_have", {}), **row}
        axes, table = own.pop("each", {}), own.pop("table", None)
        for keys in itertools.product(*axes.values()):
            yield _filled(own, _names(axes, keys) | {"cell": _cell(table, keys)})


def _names(axes: Mapping[str, Mapping[str, Any]], keys: tuple[str, ...]) -> dict[str, Any]:
    names: dict[str, Any] = {}
    for (axis, values), key in zip(axes.items(), keys, strict=True):
        about = values[key] if isinstance(values[key], Mapping) else {"title": values[key]}
        names |= {axis: key} | {f"{axis}_{name}": value for name, value in about.items()}
    return names


def _cell(table: Any, keys: tuple[str, ...]) -> Any:
    for key in keys:
        table = table[key] if isinstance(table, Mapping) else None
    return table


def _filled(template: Any, names: Mapping[str, Any]) -> Any:
    """Return a template with names filled in; a text that is one name becomes its value."""
    if isinstance(template, Mapping):
        return {key: _filled(value, names) for key, value in template.items()}
    if isinstance(template, list):
        return [_filled(value, names) for value in template]
    if not isinstance(template, str):
        return template
    name = template[1:-1] if template.startswith("{") and template.endswith("}") else ""
    return names[name] if name in names else template.format_map(names)
