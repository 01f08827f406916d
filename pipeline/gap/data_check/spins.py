"""Spin labels: their unit and sense of rotation, by the lift that the flights show.

Lift is ``S C_M w x v``. The C_M that labels imply is compared with the range of all balls, not with
a simulator, which may have it wrong or lack it. C_M varies by a factor of eight, and units by a
factor of six to ten, so the sizes of labels must speak for another unit too.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.state import MAGNUS_FACTOR
from rallygap.pipeline.gap.data_check.doubt import Doubt, Setup
from rallygap.pipeline.gap.data_check.measured import Flights
from rallygap.pipeline.io.schemas import FASTEST_SPIN
from rallygap.pipeline.sources.conversion import SPIN_UNITS, SpinUnit

UNITS: tuple[SpinUnit, ...] = ("rad/s", "rpm", "rev/s", "deg/s")
GRAVITY = 9.81  # m/s^2
TYPICAL_CM = 0.12
CM = (0.025, 0.5)  # of any ball, saturated and not
LARGEST_CM = 0.35  # above which small labels are in a larger unit
LARGEST, SMALLEST = 1000.0, 30.0  # rad/s, of the nine-tenths quantile of spins
REVOLUTIONS = 100.0  # rev/s, likewise; labels above it are no revolutions
QUANTILE = 0.9
SIGNIFICANT = 4.0  # standard errors of a lift
LEAST_LIFT = 0.3  # m/s^2, below which wind or a tilted frame may be stronger
FEWEST_FLIGHTS = 5
MOST = 0.6  # share of flights with the opposite lift from which labels are doubtful
NEARLY_ALL = 0.9  # share of flights with the opposite lift from which all labels are meant


@dataclass(frozen=True)
class Lift:
    """What flights with a significant lift say of their labels.

    Attributes:
        cm: C_M that the labels imply, if they are in rad/s.
        opposite: share of the flights whose lift has the opposite direction.
    """

    cm: float
    opposite: float


def lift_of(flights: Flights) -> Lift | None:
    """Return the lift of flights, ``None`` where too few have a significant one."""
    direction = np.cross(flights.spins, flights.velocities)
    size = np.linalg.norm(direction, axis=1)
    strong = size > np.median(size) if len(size) else size > 0
    direction, size = direction[strong], size[strong]
    excess = flights.accelerations[strong] + [0.0, 0.0, GRAVITY]
    lift = (excess * direction).sum(axis=1) / size
    clear = np.abs(lift) > np.maximum(SIGNIFICANT * flights.errors[strong], LEAST_LIFT)
    if clear.sum() < max(FEWEST_FLIGHTS, len(clear) / 2):
        return None
    cm = (lift / size)[clear] / MAGNUS_FACTOR
    return Lift(float(np.median(np.abs(cm))), float((cm < 0).mean()))


def is_opposite(flights: Flights) -> bool:
    """Return whether nearly all labels have the opposite sense of rotation."""
    lift = lift_of(flights)
    return lift is not None and lift.opposite >= NEARLY_ALL


def impossible_spins(flights: Flights, setup: Setup) -> Iterator[Doubt]:
    """Yield what is wrong with the unit and the sense of rotation of spin labels."""
    if not len(flights.spins):
        return
    quantile = float(np.quantile(np.linalg.norm(flights.spins, axis=1), QUANTILE))
    present = setup.units.spin
    unit = _best_unit(flights, quantile, present)
    opposite = is_opposite(flights)
    wrong = []
    if unit != present.lstrip("-"):
        wrong.append(f"are not in {present}, which makes their 90 % quantile {quantile:.3g} rad/s")
    elif quantile > FASTEST_SPIN:
        text = f"spin labels of {quantile:.3g} rad/s are implausible: give their unit"
        yield Doubt(text, impossible=True)
        return
    if opposite:
        wrong.append("have the opposite sense of rotation: balls curve the other way")
    if wrong:
        sign = "" if opposite == present.startswith("-") else "-"
        text = f"spin labels {' and '.join(wrong)}; {sign + unit}?"
        yield Doubt(text, impossible=True, line=setup.units_line(spin=sign + unit))


def spin_doubts(flights: Flights) -> Iterator[Doubt]:
    """Yield what is unusual about spin labels."""
    lift = lift_of(flights)
    if lift is not None and lift.opposite > MOST:
        yield Doubt(
            f"{100 * lift.opposite:.0f} % of flights curve against their spin labels: check the "
            "labels' sense of rotation"
        )


def _best_unit(flights: Flights, quantile: float, present: SpinUnit) -> str:
    """Return the unit that explains size and lift, the present one unless it explains neither."""
    lift, stated = lift_of(flights), present.lstrip("-")
    if lift is None:
        return stated
    too_small = quantile < REVOLUTIONS and lift.cm > LARGEST_CM
    if quantile <= LARGEST and not too_small:
        return stated
    misfits = {}
    for unit in UNITS:
        factor = abs(SPIN_UNITS[present]) / SPIN_UNITS[unit]
        cm = lift.cm / factor
        if SMALLEST <= quantile * factor <= LARGEST and CM[0] <= cm <= CM[1]:
            misfits[unit] = abs(np.log(cm / TYPICAL_CM))
    return min(misfits, key=lambda unit: misfits[unit], default=stated)
