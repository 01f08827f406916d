"""Amended simulators as files: what close_gap made of a simulator by the balls of a source."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from models.ball.simulator import Simulator
from pipeline.io.simulators import load_simulator

AMENDED = "amended"
FIRST = 0  # the split whose amended simulators serve others


@dataclass(frozen=True)
class Amended:
    """A simulator that was amended.

    Attributes:
        source: whose balls amended it.
        begun: name of the simulator in ``close_gap.simulators`` that it was before.
        simulator: as it is now.
    """

    source: str
    begun: str
    simulator: Simulator


def case_name(source: str, simulator: str, split: int) -> str:
    """Return what the files of a case are called; none of its parts has a hyphen."""
    return f"{source}-{simulator}-{split}"


def read_amended(folder: Path) -> Iterator[Amended]:
    """Yield the amended simulators of a folder that serve others, by name.

    Args:
        folder: that close_gap wrote.

    Raises:
        InputError: one is broken.
    """
    for path in sorted(folder.glob(f"{case_name('*', '*', FIRST)}.yaml")):
        source, begun, _ = path.stem.split("-")
        yield Amended(source, begun, load_simulator(str(path)))


def amended_by(folder: Path, source: str, begun: str) -> Simulator | None:
    """Return what the balls of a source made of a simulator; ``None`` where they were not asked.

    Args:
        folder: that close_gap wrote.
        source: of the balls.
        begun: name of the simulator.

    Raises:
        InputError: it is broken.
    """
    path = folder / f"{case_name(source, begun, FIRST)}.yaml"
    return load_simulator(str(path)) if path.exists() else None


def verdict_path(folder: Path, source: str, begun: str) -> Path:
    """Return the path of the verdict by which the balls of a source amended a simulator."""
    return folder / f"{case_name(source, begun, FIRST)}.json"
