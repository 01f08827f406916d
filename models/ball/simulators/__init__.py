"""The simulators shipped with rallygap, as YAML."""

from importlib.resources import files

import yaml

from rallygap.models.ball.simulator import Simulator, SimulatorError
from rallygap.models.support.suggestion import suggestion


def shipped_names() -> list[str]:
    """Return the names of the shipped simulators."""
    listed = (entry.name for entry in files(__name__).iterdir())
    return sorted(name.removesuffix(".yaml") for name in listed if name.endswith(".yaml"))


def shipped(name: str) -> Simulator:
    """Return the shipped simulator ``name``.

    Raises:
        SimulatorError: there is none of that name.
    """
    if name not in shipped_names():
        hint = suggestion(name, shipped_names())
        raise SimulatorError(f"there is no shipped simulator {name!r}; {hint}")
    return Simulator.from_dict(yaml.safe_load(shipped_text(name)))


def shipped_text(name: str) -> str:
    """Return the YAML of the shipped simulator ``name``: a comment, then its effects."""
    return (files(__name__) / f"{name}.yaml").read_text(encoding="utf-8")
