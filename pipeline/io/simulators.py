"""Simulators by name or by file."""

import yaml

from rallygap.models.ball.simulator import Simulator, SimulatorError
from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.runtime.errors import InputError


def load_simulator(name: str) -> Simulator:
    """Return a shipped simulator by its name, or one from the YAML file of that path.

    Raises:
        InputError: there is no such simulator, or its file does not describe one.
    """
    try:
        if name.endswith((".yaml", ".yml")):
            return Simulator.load(name)
        return shipped(name)
    except SimulatorError as error:
        raise InputError(name, error.problem) from None


def simulator_yaml(simulator: Simulator) -> str:
    """Return a simulator as the content of a YAML file."""
    return yaml.safe_dump(simulator.to_dict(), sort_keys=False)
