"""Limits: what data cannot decide, why, and which experiment would."""

from collections.abc import Iterator, Sequence

import numpy as np

from models.ball.catalogue import catalogue
from models.gap.fit.shots import Shots
from models.gap.verdict import Cause, Gap

FEW = 20  # shots
TABLE = {"restitution", "friction"}
ONE_WAY = 0.9  # of the shots in the same direction
WANDERING = (
    "other causes are found whenever those found before are put into the simulator: these shots "
    "tell that it is wrong, not by what; record more shots, other ones, and their spins"
)


def limits(shots: Shots, causes: Sequence[Cause], blind_to: Sequence[str]) -> tuple[str, ...]:
    """Return in words what shots cannot decide, and what would split the classes of causes."""
    blind = set(blind_to) >= TABLE
    table = ["no bounces: nothing of the table can be judged; let balls bounce"] if blind else []
    return (
        *_of_shots(shots),
        *table,
        *(_split(one, shots) for one in causes if len(one.possible) > 1),
        *(_at_the_end(one) for one in causes if one.estimate in one.interval),
    )


def misled(gap: Gap) -> str:
    """Return in words that causes explain the shots they were found on, and no others."""
    before, after = (np.mean(sizes) for sizes in (gap.before_mm, gap.after_mm))
    return (
        f"with the causes in it the simulator errs by {after:.1f} mm and not {before:.1f} mm on "
        "shots that naming never saw: they stand for something else, and it stays as it was; "
        "record more shots, other ones, and their spins"
    )


def _of_shots(shots: Shots) -> Iterator[str]:
    if len(shots) < FEW:
        yield f"{len(shots)} shots: small effects stay hidden; record {FEW} or more"
    if not shots.labelled.any():
        yield "no spin labels: spin sensors cannot be judged, and lift only by its curves"
    if _one_way(shots):
        yield "all shots go one way: wind, tilts and drag look alike; shoot both ways"


def _split(cause: Cause, shots: Shots) -> str:
    return f"{' or '.join(cause.possible)}: to tell them apart, {experiment(cause, shots)}"


def _at_the_end(cause: Cause) -> str:
    """Return in words that an estimate is at its bound: only there do intervals end at it."""
    size = f"{cause.estimate:.4g}" + (f" {cause.unit}" if cause.unit != "1" else "")
    return f"{cause.name}: {size} is the end of what makes sense; something else may be behind it"


def experiment(cause: Cause, shots: Shots) -> str:
    """Return what to do so that the members of a cause's class part."""
    phases = {_acts(name) for name in cause.possible}
    if "sensor" in phases:
        return "film a scale, a clock or a ball of known spin with the same cameras"
    if _one_way(shots):
        return "shoot both ways"
    if not shots.labelled.any():
        return "measure the spin"
    if (shots.labelled.sum(axis=1) <= 1).all():
        return "measure the spin after the bounce, too"
    if phases == {"contact"}:
        return "let balls bounce at a wider range of falls, slips and spins"
    if "gravity" in cause.possible:
        return "weigh the ball, and drop a still one"
    return "shoot at a wider range of speeds and spins"


def _acts(name: str) -> str:
    return catalogue()[name].acts if name in catalogue() else "contact"


def _one_way(shots: Shots) -> bool:
    last = shots.valid.sum(axis=1) - 1
    end = shots.positions[np.arange(len(shots)), last]
    towards = np.sign((end - shots.positions[:, 0])[:, 1]).mean()
    return bool(abs(towards) > 2 * ONE_WAY - 1)
