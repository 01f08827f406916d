"""Audits of engines, and the lists of effects that stand for them."""

from collections.abc import Callable
from dataclasses import replace

from rallygap.models.audit.audit import PATIENCE, Audit, audit
from rallygap.models.audit.probes import bounce_probes
from rallygap.models.audit.traps import traps
from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.engine import EffectsEngine, Engine, EngineError, check_deterministic
from rallygap.pipeline.engines.audit_text import outcome
from rallygap.pipeline.engines.load import load_engine
from rallygap.pipeline.runtime.errors import InputError

FEW = 6  # probes that are flown twice


def audited(
    engine: Engine,
    progress: Callable[[float], None] = lambda share: None,
    patience: float = PATIENCE,
) -> Audit:
    """Return the audit of an engine; its values have six significant digits.

    Args:
        engine: to be audited.
        progress: called with the share of the work that is done.
        patience: s for the probes of a phase, as ``audit`` takes it.

    Raises:
        InputError: the engine fails.
    """
    probes = bounce_probes()
    try:
        check_deterministic(engine, probes.states[:FEW], probes.times)
        found = audit(engine, progress, patience)
    except EngineError as error:
        raise InputError(engine.name, str(error).removeprefix(f"{engine.name} ")) from None
    return replace(found, simulator=_rounded(found.simulator))


def effects_of(name: str, say: Callable[[str], None]) -> Simulator:
    """Return a simulator as a list of effects; one that is none is audited first.

    Args:
        name: as ``load_engine`` takes it.
        say: called with the outcome of the audit, in sentences.

    Raises:
        InputError: there is no such engine, or it fails.
    """
    engine = load_engine(name)
    if isinstance(engine, EffectsEngine):
        return engine.simulator
    found = audited(engine)
    for line in outcome(name, found, traps(found)):
        say(line)
    return found.simulator


def _rounded(simulator: Simulator) -> Simulator:
    rounded = {
        name: {key: float(f"{value:.6g}") for key, value in values.items()}
        for name, values in simulator.to_dict().items()
    }
    return Simulator.from_dict(rounded)
