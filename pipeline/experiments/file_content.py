"""Whether two versions of a file do the same: comments and docstrings change no result."""

import ast
import json
from pathlib import PurePath
from typing import Any

import yaml


def do_the_same(name: str, before: str, after: str) -> bool:
    """Whether two versions of a file differ at most in comments, docstrings and layout.

    Args:
        name: of the file; only Python, YAML and JSON are understood.
        before: one text.
        after: the other.
    """
    readers = {".py": _code, ".yaml": _values, ".json": _undescribed}
    read = readers.get(PurePath(name).suffix, str)
    try:
        return read(before) == read(after)
    except (SyntaxError, yaml.YAMLError, json.JSONDecodeError):
        return before == after


def _code(text: str) -> str:
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [one for one in node.body if not _is_docstring(one)]
    return ast.dump(tree)


def _is_docstring(node: ast.stmt) -> bool:
    """Whether a statement is a text alone, which documents what is above it."""
    if not isinstance(node, ast.Expr) or not isinstance(node.value, ast.Constant):
        return False
    return isinstance(node.value.value, str)


def _undescribed(text: str) -> str:
    """Return JSON without the descriptions that a schema takes from docstrings."""

    def without_description(node: dict[str, Any]) -> dict[str, Any]:
        return {key: value for key, value in node.items() if key != "description"}

    return repr(json.loads(text, object_hook=without_description))


def _values(text: str) -> str:
    # 1 and 1.0 are equal, but not the same parameter.
    return repr(yaml.safe_load(text))
