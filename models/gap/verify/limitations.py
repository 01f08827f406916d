"""Limitations: what the data cannot decide, why, and which experiment would decide it."""

from collections.abc import Iterator, Sequence

import numpy as np

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.name.label_readings import LabelReadings
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.verdict import Cause, DetectionLimits

CAMERA = "camera_distortion"
BOUNCE = {"table_bounce.restitution", "table_bounce.friction"}
UNSETTLED = (
    "the causes do not converge: with them in the simulator, other causes are found. The shots "
    "show that the simulator is wrong, but not why. Record more shots at other speeds and spins, "
    "and measure spins"
)
USELESS = (
    "spin labels err by more than half of the spin: they are not used, and lift is judged only by "
    "curvature. Check the spin sensor against a ball of known spin"
)


def limitations(
    shots: Shots,
    causes: Sequence[Cause],
    limits: DetectionLimits,
    settled: bool,
    settings: GapSettings,
) -> tuple[str, ...]:
    """Return what the shots cannot decide and what would, one sentence each."""
    no_bounce = set(limits.not_identifiable) >= BOUNCE
    return (
        *_of_shots(shots, settings),
        *(["no bounces: the table cannot be judged; let balls bounce"] if no_bounce else []),
        *(_to_separate(cause, shots, settings) for cause in causes if cause.alternatives),
        *(
            _of_cameras(cause, shots, settings)
            for cause in causes
            if cause.effect == CAMERA and cause.role != "minor"
        ),
        *(_at_bound(cause) for cause in causes if cause.hypothesis.is_bound(cause.estimate)),
        *(() if settled else (UNSETTLED,)),
    )


def of_labels(readings: LabelReadings) -> tuple[str, ...]:
    """Return which labels are not used, one sentence each."""
    if readings.useless:
        return (USELESS,)
    count = len(readings.outliers)
    used = f"{count} of {readings.labelled} spin labels are outliers and not used"
    return (used,) if count else ()


def experiment(cause: Cause, shots: Shots, settings: GapSettings) -> str:
    """Return the experiment that separates the possible causes of a class."""
    phases = {catalogue()[identity.partition(".")[0]].acts for identity in cause.possible}
    if "sensor" in phases:
        return "record a scale, a clock or a ball of known spin with the same cameras"
    if _one_way(shots, settings):
        return "record shots in both directions"
    if not shots.labelled.any():
        return "measure the spin"
    if (shots.labelled.sum(axis=1) <= 1).all():
        return "measure the spin after the bounce as well"
    if phases == {"contact"}:
        return "record bounces over a wider range of impact speeds, slip and spin"
    if "gravity.g" in cause.possible:
        return "weigh the ball, and record the fall of one without spin"
    return "record shots over a wider range of speeds and spins"


def _of_shots(shots: Shots, settings: GapSettings) -> Iterator[str]:
    few = settings.verify.few_shots
    if len(shots) < few:
        yield f"{len(shots)} shots: small effects are not detected; record {few} or more"
    if not shots.labelled.any():
        yield "no spin labels: errors of spin labels are not identifiable, lift only by curvature"
    if _one_way(shots, settings):
        yield "all shots go in one direction: wind, tilt and drag look alike; record shots in both"


def _to_separate(cause: Cause, shots: Shots, settings: GapSettings) -> str:
    others = ", ".join(cause.alternatives)
    return f"{cause.identity} is not separable from {others}: {experiment(cause, shots, settings)}"


def _of_cameras(cause: Cause, shots: Shots, settings: GapSettings) -> str:
    """Return which effects look like a position-dependent camera error, as they move places."""
    also = ", and from wind, drag and lift, as all shots go in one direction"
    return (
        f"{cause.identity}: up to its size, {1e3 * cause.estimate:.1f} mm, it is not separable "
        "from position_scale, frame_tilt, table_height and table_tilt"
        f"{also if _one_way(shots, settings) else ''}: measure points of known place with the "
        "same cameras"
    )


def _at_bound(cause: Cause) -> str:
    size = f"{cause.estimate:.4g}" + (f" {cause.unit}" if cause.unit != "1" else "")
    return (
        f"{cause.identity}: {size} is the bound of physically plausible values; the cause may be "
        "another one"
    )


def _one_way(shots: Shots, settings: GapSettings) -> bool:
    last = shots.valid.sum(axis=1) - 1
    end = shots.positions[np.arange(len(shots)), last]
    towards = np.sign((end - shots.positions[:, 0])[:, 1]).mean()
    return bool(abs(towards) > 2 * settings.verify.one_way_share - 1)
