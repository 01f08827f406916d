"""What a verdict was made from: data, simulator, settings and version, for its file."""

from importlib.metadata import version
from pathlib import Path

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.verdict import MadeFrom


def made_from(
    data: str,
    folder: str | None,
    counts: tuple[int, int],
    simulator: Simulator,
    simulator_name: str,
    level: float,
) -> MadeFrom:
    """Return what a verdict was made from.

    Args:
        data: name of the source.
        folder: name of the folder of the recordings, if there is one.
        counts: of recordings and of shots.
        simulator: the nominal one.
        simulator_name: a shipped one's name, or a path, of which only the file's name is kept.
        level: probability of a false cause where there is no gap.
    """
    recordings, shots = counts
    return MadeFrom(
        data=data,
        folder=folder,
        recordings=recordings,
        shots=shots,
        simulator=Path(simulator_name).name,
        effects=simulator.to_dict(),
        settings={"level": level},
        version=version("rallygap"),
    )
