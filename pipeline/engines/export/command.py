"""``rallygap export``: a list of effects in, a file for an engine out."""

from pathlib import Path

from pipeline.engines.export.code import ENGINES, ball_effects
from pipeline.io.artifacts import write_text
from pipeline.io.simulators import load_simulator
from pipeline.runtime.errors import InputError


def export(simulator: str, engine: str, out: Path) -> None:
    """Write a simulator's flight and bounce as code for an engine.

    Args:
        simulator: name of a shipped one, or its YAML file, whose comments go into the code.
        engine: one of ``ENGINES``.
        out: file to write.

    Raises:
        InputError: the simulator cannot be read, there is no such engine, or the file cannot be
            written.
    """
    if engine not in ENGINES:
        raise InputError("--to", f"{engine} is no engine; give {' or '.join(ENGINES)}")
    try:
        write_text(out, code_of(simulator, engine))
    except OSError as error:
        raise InputError(out, f"cannot be written: {error.strerror}") from None


def code_of(simulator: str, engine: str) -> str:
    """Return a simulator's flight and bounce as code for an engine.

    Args:
        simulator: name of a shipped one, or its YAML file, whose comments go into the code.
        engine: one of ``ENGINES``.

    Raises:
        InputError: the simulator cannot be read.
    """
    known = load_simulator(simulator)
    return ball_effects(known, Path(simulator).name, _comments(simulator), engine)


def _comments(simulator: str) -> list[str]:
    """Return the comments of a YAML file: where its values come from."""
    if not simulator.endswith((".yaml", ".yml")):
        return []
    lines = Path(simulator).read_text(encoding="utf-8").splitlines()
    return [line.removeprefix("# ") for line in lines if line.startswith("# ")]
