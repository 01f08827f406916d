"""The simulators that come with rallygap, as YAML."""

from importlib.resources import files

import yaml

from models.ball.simulator import Simulator, SimulatorError


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
        raise SimulatorError(f"no simulator {name!r} is shipped; there are: {shipped_names()}")
    return Simulator.from_dict(yaml.safe_load((files(__name__) / f"{name}.yaml").read_text()))
