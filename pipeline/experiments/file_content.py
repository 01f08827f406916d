"""What a file does: comments and docstrings change no result."""

import ast
from pathlib import PurePath

import yaml


def do_the_same(name: str, before: str, after: str) -> bool:
    """Whether two versions of a file differ at most in comments, docstrings and layout.

    Args:
        name: of the file; only Python and YAML are understood.
        before: one text.
        after: the other.
    """
    return effective_content(name, before) == effective_content(name, after)


def effective_content(name: str, text: str) -> str:
    """Return what is the same for all versions of a file that do the same; a text as it is."""
    readers = {".py": _code, ".yaml": _values}
    try:
        return readers.get(PurePath(name).suffix, str)(text)
    except (SyntaxError, yaml.YAMLError):
        return text


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


def _values(text: str) -> str:
    # 1 and 1.0 are equal, but not the same parameter.
    return repr(yaml.safe_load(text))
