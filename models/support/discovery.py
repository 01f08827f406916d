"""Discovery of plugins: modules of a package and entry points of other packages."""

import importlib
import pkgutil
from importlib.metadata import entry_points
from types import ModuleType
from typing import Any


def discovered(package: ModuleType, attribute: str, group: str) -> list[Any]:
    """Return the ``attribute`` of every module of a package and of its entry points.

    Args:
        package: its modules each have the attribute.
        attribute: name of the plugin object.
        group: entry point group for modules of other packages.
    """
    names = sorted(module.name for module in pkgutil.iter_modules(package.__path__))
    modules = [importlib.import_module(f"{package.__name__}.{name}") for name in names]
    offers = sorted(entry_points(group=group), key=lambda offer: offer.name)
    return [getattr(module, attribute) for module in [*modules, *(o.load() for o in offers)]]
