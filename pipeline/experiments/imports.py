"""Which packages of the repository a module imports, directly or not."""

import sys
from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING

from rallygap.pipeline.runtime.paths import repository_root

if TYPE_CHECKING:
    import grimp

# What everything runs in but what does not shape results.
NO_RESULTS = ("rallygap.pipeline.params", "rallygap.pipeline.tracking")


def imported_packages(entries: Iterable[str]) -> set[str]:
    """Return the packages that modules import, and those of the modules, as paths.

    A package that is imported itself is a folder of plugins, all of which are loaded.

    Args:
        entries: names of modules or packages.

    Returns:
        Such as ``models/ball`` and ``stages/segment``.
    """
    graph, reached, todo = import_graph(), set(), list(entries)
    while todo:
        module = todo.pop()
        if module in reached or module.startswith(NO_RESULTS):
            continue
        reached.add(module)
        todo += graph.find_modules_directly_imported_by(module)
        todo += graph.find_children(module)
    paths = (module.removeprefix("rallygap.").split(".") for module in reached)
    return {"/".join(path[:2]) for path in paths if path != ["rallygap"]}


@cache
def import_graph() -> "grimp.ImportGraph":
    """Return which module of the repository imports which."""
    import grimp

    root = str(repository_root())
    if root not in sys.path:
        sys.path.append(root)  # the benchmarks are not installed
    return grimp.build_graph("rallygap", "benchmarks")
