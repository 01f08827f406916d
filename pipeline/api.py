"""Simulators and audits for notebooks and scripts, which import them from ``rallygap``."""

from collections.abc import Callable
from pathlib import Path

from rallygap.models.audit.audit import Audit
from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.engine import Engine, Flies, FunctionEngine
from rallygap.pipeline.engines.audited import audited, effects_of
from rallygap.pipeline.engines.load import load_engine

AnySimulator = str | Path | Flies
"""A shipped simulator's name, a YAML file with a list of effects, ``scene.xml`` of MuJoCo (or
``scene.xml#body``), ``file.py:function``, or a function that flies balls."""


def load_simulator(simulator: AnySimulator) -> Simulator:
    """Return a simulator as a list of effects; a scene or a function is audited first.

    Raises:
        InputError: there is no such simulator, or it cannot fly the probe shots.
    """
    if callable(simulator):
        return audit(simulator).simulator
    return effects_of(str(simulator), say=lambda line: None)


def audit(simulator: AnySimulator, progress: Callable[[float], None] = lambda share: None) -> Audit:
    """Fly probe shots and return the effects that a simulator really has, with their values.

    Args:
        simulator: to be audited.
        progress: called with the share of the work that is done.

    Raises:
        InputError: there is no such simulator, or it cannot fly the probe shots.
    """
    return audited(_engine(simulator), progress)


def _engine(simulator: AnySimulator) -> Engine:
    if callable(simulator):
        return FunctionEngine(getattr(simulator, "__name__", "simulator"), simulator)
    return load_engine(str(simulator))
