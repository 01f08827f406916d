"""Audits of engines, and the lists of effects that stand for them."""

import hashlib
import pickle
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import platformdirs

import rallygap.models.engines.engine as engine_module
from rallygap.models.audit.audit import PATIENCE, Audit, audit
from rallygap.models.audit.probes import bounce_probes
from rallygap.models.audit.traps import traps
from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.engine import EffectsEngine, Engine, EngineError, check_deterministic
from rallygap.pipeline.engines.audit_text import outcome
from rallygap.pipeline.engines.load import load_engine
from rallygap.pipeline.io.artifacts import replacing
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
        made = audit(engine, progress, patience)
    except EngineError as error:
        raise InputError(engine.name, str(error).removeprefix(f"{engine.name} ")) from None
    rounded = {
        name: {key: float(f"{value:.6g}") for key, value in values.items()}
        for name, values in made.simulator.to_dict().items()
    }
    return replace(made, simulator=Simulator.from_dict(rounded))


def cached_audit(engine: Engine, progress: Callable[[float], None] = lambda share: None) -> Audit:
    """Return the audit of an engine; that of a scene of MuJoCo is read from the user's cache.

    An entry there is of this scene with all that its file includes and loads, of this code and of
    this version of MuJoCo. One that cannot be read is replaced.

    Args:
        engine: to be audited.
        progress: called with the share of the work that is done.

    Raises:
        InputError: the engine fails.
    """
    content = getattr(engine, "content", None)  # that of a scene
    if content is None:
        return audited(engine, progress)
    path = platformdirs.user_cache_path("rallygap") / "audits" / f"{_digest(content)}.pickle"
    with suppress(Exception):  # whatever a broken entry raises
        entry = pickle.loads(path.read_bytes())
        if isinstance(entry, Audit):
            progress(1.0)
            return entry
    made = audited(engine, progress)
    with suppress(OSError), replacing(path) as temporary:
        temporary.write_bytes(pickle.dumps(made))
    return made


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
    made = cached_audit(engine)
    for line in outcome(name, made, traps(made)):
        say(line)
    return made.simulator


def _digest(content: bytes) -> str:
    """Return a digest of a scene, of the code that audits it and of MuJoCo's version."""
    digest = hashlib.sha256(version("mujoco").encode() + content + Path(__file__).read_bytes())
    models = Path(engine_module.__file__).parents[1]
    for path in sorted([*models.rglob("*.py"), *models.rglob("*.yaml")]):
        digest.update(path.relative_to(models).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()
