"""Amended simulators as files: close_gap amends a simulator for the recordings of a source."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from rallygap.models.ball.simulator import Simulator
from rallygap.pipeline.io.simulators import load_simulator

AMENDED = "amended"
FIRST = 0  # the split whose amended simulators serve others


class Amended(NamedTuple):
    """A simulator, the source it was amended for, and what it was in ``close_gap.simulators``."""

    source: str
    base: str
    simulator: Simulator


def case_name(source: str, simulator: str, split: int) -> str:
    """Return what the files of a case are called; none of its parts has a hyphen."""
    return f"{source}-{simulator}-{split}"


def read_amended(folder: Path) -> Iterator[Amended]:
    """Yield the amended simulators of close_gap's folder that serve others, by name.

    Raises:
        InputError: one is broken.
    """
    for path in sorted(folder.glob(f"{case_name('*', '*', FIRST)}.yaml")):
        source, base, _ = path.stem.split("-")
        yield Amended(source, base, load_simulator(str(path)))


def amended_by(folder: Path, source: str, base: str) -> Simulator | None:
    """Return a simulator amended for a source; ``None`` where close_gap did not compare the two.

    Raises:
        InputError: it is broken.
    """
    path = folder / f"{case_name(source, base, FIRST)}.yaml"
    return load_simulator(str(path)) if path.exists() else None


def verdict_path(folder: Path, source: str, base: str) -> Path:
    """Return the path of the verdict by which a simulator was amended for a source."""
    return folder / f"{case_name(source, base, FIRST)}.json"
