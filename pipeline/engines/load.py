"""Engines by what users give: a simulator's name, a list of effects, a scene, or a function."""

import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from rallygap.models.engines.engine import EffectsEngine, Engine, FunctionEngine
from rallygap.models.support.suggestion import suggestion
from rallygap.pipeline.engines.mujoco_file import load_scene
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError


def load_engine(name: str) -> Engine:
    """Return the engine that a user names.

    Args:
        name: a shipped simulator's name, the path of a YAML list of effects, a scene of MuJoCo:
            ``scene.xml`` or ``scene.xml#body`` of the ball, or a function: ``file.py:function`` or
            ``package.module:function``, of the form ``Flies``.

    Raises:
        InputError: there is no such engine, or its code fails when it is imported.
    """
    if names_scene(name):
        path, _, ball = name.partition("#")
        return load_scene(path, ball or None)
    if names_function(name):
        place, _, function = name.rpartition(":")
        return FunctionEngine(name, _function(name, _module(place), function))
    return EffectsEngine(name, load_simulator(name))


def names_scene(name: str) -> bool:
    """Whether a name is that of a scene of MuJoCo."""
    return name.partition("#")[0].endswith(".xml")


def names_function(name: str) -> bool:
    """Whether a name is that of a function, and not of a list of effects."""
    place, _, function = name.rpartition(":")
    return bool(place) and function.isidentifier()


def _function(name: str, module: ModuleType, function: str) -> Any:
    found = getattr(module, function, None)
    if not callable(found):
        known = [one for one in vars(module) if not one.startswith("_")]
        raise InputError(name, f"has no function {function!r}; {suggestion(function, known)}")
    return found


def _module(place: str) -> ModuleType:
    """Import a module by its file or by its name; modules of the working directory are found."""
    try:
        return module_of_file(Path(place)) if place.endswith(".py") else _of_name(place)
    except InputError:
        raise
    except Exception as error:  # of whatever kind: the code is the user's
        problem = f"cannot be imported: {type(error).__name__}: {error}"
        raise InputError(place, problem) from error


def _of_name(name: str) -> ModuleType:
    sys.path.insert(0, str(Path.cwd()))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.pop(0)


def module_of_file(path: Path) -> ModuleType:
    """Import a file as a module; its neighbours are found.

    Raises:
        InputError: there is no such file.
    """
    if not path.is_file():
        raise InputError(path, "there is no such file; give file.py:function")
    described = importlib.util.spec_from_file_location(path.stem, path)
    assert described is not None and described.loader is not None  # its name ends with .py
    module = importlib.util.module_from_spec(described)
    sys.path.insert(0, str(path.resolve().parent))  # it may import its neighbours
    try:
        described.loader.exec_module(module)
    finally:
        sys.path.pop(0)
    return module
