"""Engines by what users give: a simulator's name, a list of effects, a scene, or a function."""

import importlib
import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from rallygap.models.engines.engine import EffectsEngine, Engine, EngineError, FunctionEngine
from rallygap.models.support.suggestion import suggestion
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError

if TYPE_CHECKING:
    from rallygap.models.engines.mujoco.scene import MujocoScene


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
        return load_scene(name)
    if names_function(name):
        place, _, function = name.rpartition(":")
        module = _module(place)
        member = getattr(module, function, None)
        if not callable(member):
            known = [own for own in vars(module) if not own.startswith("_")]
            raise InputError(name, f"has no function {function!r}; {suggestion(function, known)}")
        return FunctionEngine(name, member)
    return EffectsEngine(name, load_simulator(name))


def load_scene(name: str) -> "MujocoScene":
    """Read a scene from its MJCF file.

    Args:
        name: ``scene.xml``, or ``scene.xml#body`` of the ball.

    Raises:
        InputError: MuJoCo is not installed or cannot read the file, or the scene has no ball.
    """
    path, _, ball = name.partition("#")
    try:
        import mujoco

        from rallygap.models.engines.mujoco.scene import MujocoScene
    except ImportError as error:
        advice = "pip install -e '.[mujoco]' brings MuJoCo, which flies this scene"
        raise InputError(path, f"{advice} ({_one_line(error)})") from None
    if not Path(path).is_file():
        raise InputError(path, "there is no such file")
    with scene_errors(path):
        return MujocoScene.of(Path(path).stem, mujoco.MjModel.from_xml_path(path), ball or None)


@contextmanager
def scene_errors(path: Path | str) -> Iterator[None]:
    """Raise errors of MuJoCo about a scene's file as ``InputError``, in one line each."""
    import mujoco

    from rallygap.models.engines.mujoco.simulation import collected_warnings

    try:
        with collected_warnings():
            yield
    except EngineError as error:
        raise InputError(path, str(error)) from None
    except (ValueError, mujoco.FatalError) as error:
        raise InputError(path, f"MuJoCo cannot read it: {_one_line(error)}") from None


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def names_scene(name: str) -> bool:
    """Whether a name is that of a scene of MuJoCo."""
    return name.partition("#")[0].endswith(".xml")


def names_function(name: str) -> bool:
    """Whether a name is that of a function, and not of a list of effects."""
    place, _, function = name.rpartition(":")
    return bool(place) and function.isidentifier()


def _module(place: str) -> ModuleType:
    """Import a module by its file or by its name; modules of the working directory are found."""
    try:
        if place.endswith(".py"):
            return module_of_file(Path(place))
        with _found_in(Path.cwd()):
            return importlib.import_module(place)
    except InputError:
        raise
    except Exception as error:  # of whatever kind: the code is the user's
        problem = f"cannot be imported: {type(error).__name__}: {error}"
        raise InputError(place, problem) from error


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
    with _found_in(path.resolve().parent):
        described.loader.exec_module(module)
    return module


@contextmanager
def _found_in(folder: Path) -> Iterator[None]:
    """Let modules of a folder be imported."""
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path.pop(0)
