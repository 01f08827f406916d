"""The check of recordings before any verdict: units, axes, heights, spin labels, time stamps.

``doubts`` says what is doubtful about what was measured. Each doubt has the line of source.yaml
that corrects it, where one does.

Spin labels are checked by the lift that the flights show, ``S C_M w x v``. The C_M that they imply
is compared with the range of all balls, not with a simulator, which may have it wrong or lack it.
C_M varies by a factor of eight, and units by a factor of six to ten, so the sizes of labels must
speak for another unit too.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rallygap.models.ball.state import (
    BALL_RADIUS,
    MAGNUS_FACTOR,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from rallygap.models.ball.types import Floats
from rallygap.pipeline.gap.data_check.measured import Fall, Flights, Measured, bounce_places
from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.io.schemas import FASTEST_SPIN
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.conversion import (
    POSITION_UNITS,
    SPIN_UNITS,
    TIME_UNITS,
    Conversion,
    SpinUnit,
)
from rallygap.pipeline.sources.source import RawTable

GRAVITY = 9.81  # m/s^2
# m/s^2 of a falling ball, with the lift of any spin; between units lies a factor of ten or more.
FALLS = (1.0, 60.0)
LIKELY_FALLS = (6.0, 15.0)  # m/s^2 beyond which lift is an unlikely explanation
TILT = 30.0  # degrees between gravity and -z; less may be lift
EXTENTS = (0.2, 15.0)  # m, largest extent of a typical recording

DOMINANT = 2.0  # ratio of two axes' components above which one of them is meant
BETTER = 0.2  # share of bounces on the table that an exchange of x and y must add
# The axes across and along the table if one axis, exchanged with z, is vertical.
EXCHANGED = {0: (2, 1), 1: (0, 2), 2: (0, 1)}

BAND = 0.06  # m to either side of the most frequent height
FEWEST_BOUNCES = 3
LEAST_SHARE = 0.5  # of all bounces at the most frequent height
WRONG, DOUBTFUL = 0.10, 0.04  # m from the expected height
FLOOR = 0.76  # m from the floor to the table's surface, ITTF Law 2.1
NEAR_FLOOR = 0.01  # m, within which the official height is meant
STEEP = 0.03  # slope of the surface that bounces show
FEWEST_SLOPE = 10  # bounces that show a slope
EDGE = 0.05  # m beyond the table, for errors of positions
FEWEST_PLACED = 5  # bounces that show where the table is

UNITS: tuple[SpinUnit, ...] = ("rad/s", "rpm", "rev/s", "deg/s")
TYPICAL_CM = 0.12
CM = (0.025, 0.5)  # of any ball, saturated and not
LARGEST_CM = 0.35  # above which small labels are in a larger unit
SPINS = (30.0, 1000.0)  # rad/s, of the nine-tenths quantile of spins
REVOLUTIONS = 100.0  # rev/s, likewise; labels above it are no revolutions
QUANTILE = 0.9
SIGNIFICANT = 4.0  # standard errors of a lift
LEAST_LIFT = 0.3  # m/s^2, below which wind or a tilted frame may be stronger
FEWEST_FLIGHTS = 5
MOST = 0.6  # share of flights with the opposite lift from which labels are doubtful
NEARLY_ALL = 0.9  # share of flights with the opposite lift from which all labels are meant

ROUNDED = 1e-3  # s
ROUNDING_ERROR = 1e-6  # s, of a time stamp that is a multiple of ROUNDED
FEWEST_SPEEDS = 5  # recordings whose speeds are compared
SAME_SPEED = 0.05  # relative standard deviation of the speeds of recordings


@dataclass(frozen=True)
class Doubt:
    """What is doubtful about recordings.

    Attributes:
        text: a sentence about the recordings, without a full stop.
        impossible: whether it cannot be right, rather than being unusual.
        line: of source.yaml that corrects it, empty where none does.
    """

    text: str
    impossible: bool = False
    line: str = ""


@dataclass(frozen=True)
class Setup:
    """How a source transforms its rows: the lines of source.yaml as they are.

    Attributes:
        frame: transformation into the table frame.
        conversion: axes and units of the columns.
    """

    frame: Frame
    conversion: Conversion

    def units_line(self, **changes: str) -> str:
        """Return the line with changed units."""
        units = self.conversion.units.model_copy(update=changes).model_dump(exclude_defaults=True)
        return f"units: {{{', '.join(f'{name}: {unit}' for name, unit in units.items())}}}"

    def axes_line(self, order: Sequence[int]) -> str:
        """Return the line with which table axis ``i`` is the present axis ``order[i]``."""
        names = ["xyz"[order.index("xyz".index(axis))] for axis in self.conversion.axes]
        return f"axes: [{', '.join(names)}]"

    def frame_line(self, rotation: Floats, offset: Floats) -> str:
        """Return the line with a further rotation (3, 3) and then a further offset (3,), m."""
        whole = rotation @ np.array(self.frame.rotation)
        moved = rotation @ np.array(self.frame.offset) + offset
        parts = []
        if not (whole == np.eye(3)).all():
            parts.append(f"rotation: [{', '.join(map(_numbers, whole))}]")
        if moved.any():
            parts.append(f"offset: {_numbers(moved)}")
        return f"frame: {{{', '.join(parts)}}}"


def _numbers(values: Floats) -> str:
    return f"[{', '.join(f'{value + 0.0:.6g}' for value in values)}]"


def check_recordings(
    tables: Sequence[RawTable], frame: Frame, conversion: Conversion | None, folder: Path
) -> tuple[str, ...]:
    """Return what is doubtful about raw recordings, one sentence each, without a full stop.

    Args:
        tables: recordings as the source reads them.
        frame: their transformation into the table frame.
        conversion: axes and units that source.yaml states; ``None`` for a source without one.
        folder: of the files, for messages.

    Raises:
        InputError: something cannot be right. The message has the line of source.yaml that
            corrects it.
    """
    unusual = []
    for doubt in doubts(Measured.by(tables, frame), Setup(frame, conversion or Conversion())):
        if doubt.impossible:
            told = doubt.line if conversion else ""
            advice = f"; source.yaml needs the line `{told}`" if told else ""
            raise InputError(folder, f"{doubt.text}{advice}")
        unusual.append(doubt.text)
    return tuple(unusual)


def doubts(measured: Measured, setup: Setup) -> Iterator[Doubt]:
    """Yield what is doubtful: first what is impossible, from units to spin labels.

    What follows an impossible one assumes that it is corrected, so that a reader stops there.
    """
    if not measured.tracks:
        return
    yield from _impossible_units(measured, setup)
    yield from _impossible_axes(measured, setup)
    yield from _impossible_heights(measured, setup)
    yield from _impossible_spins(measured.flights, setup)
    yield from _unusual_falls(measured)
    yield from _unusual_heights(measured.bounces)
    lift = Lift.of(measured.flights)
    if lift is not None and lift.opposite > MOST:
        yield Doubt(
            f"{100 * lift.opposite:.0f} % of flights curve against their spin labels: check the "
            "labels' sense of rotation"
        )
    positions = measured.bounces
    if len(positions) >= FEWEST_PLACED and _share_on_table(positions) < 0.5:
        x, y = np.median(positions[:, :2], axis=0)
        yield Doubt(
            f"most bounces are outside the table, typically at x = {x:.2f} m and y = {y:.2f} m: "
            "check that the origin is at the table's centre"
        )
    yield from _unusual_samples(measured)


def _impossible_units(measured: Measured, setup: Setup) -> Iterator[Doubt]:
    """Yield what is wrong with units, from the frame interval and from how fast the ball falls."""
    units, changes, wrong = setup.conversion.units, {}, []
    second, metre = measured.second, _metre(measured, POSITION_UNITS[units.position])
    if second != 1:
        changes["time"] = _unit(TIME_UNITS, TIME_UNITS[units.time] * second)
        wrong.append(f"t is not in {units.time}: samples would be {measured.step:.4g} s apart")
    if metre != 1:
        changes["position"] = _unit(POSITION_UNITS, POSITION_UNITS[units.position] * metre)
        extent = f"recordings would extend over {measured.extent:.4g} m"
        wrong.append(f"positions are not in {units.position}: {extent}")
    if wrong:
        guesses = " and ".join(unit or "another unit" for unit in changes.values())
        line = setup.units_line(**changes) if all(changes.values()) else ""
        yield Doubt(f"{', and '.join(wrong)}; {guesses}?", impossible=True, line=line)
    fall = measured.fall
    if fall is not None and fall.size > FALLS[1]:
        text = f"the ball falls with {fall.size:.3g} m/s^2: are t in s and positions in m?"
        yield Doubt(text, impossible=True)


def _metre(measured: Measured, stated: float) -> float:
    """Return how many units of positions make a metre; 1 where no unit explains the fall better."""
    fall, extent = measured.fall, measured.extent
    if fall is None or _within(fall.size, FALLS):
        return 1.0
    possible = [
        scale
        for scale in np.array(list(POSITION_UNITS.values())) / stated
        if _within(fall.size / scale, FALLS) and _within(extent / scale, EXTENTS)
    ]
    return min(possible, key=lambda scale: abs(np.log(fall.size / scale / GRAVITY)), default=1.0)


def _unit(units: Mapping[str, float], number: float) -> str:
    """Return the unit of which so many make an SI unit; empty if there is none."""
    return next((name for name, size in units.items() if abs(size / number - 1) < 1e-6), "")


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]


def _impossible_axes(measured: Measured, setup: Setup) -> Iterator[Doubt]:
    """Yield which axes are exchanged or turned around.

    Gravity points along -z, and balls fly along y rather than across the table.
    """
    fall = measured.fall
    if fall is None:
        return
    axis, sign = _up(fall, measured.flights)
    horizontal = EXCHANGED[axis]
    positions = bounce_places(measured.flights.contacts, sign * np.eye(3)[axis])[:, horizontal]
    if _mostly_across(fall.velocities[:, horizontal]) and len(positions):
        exchanged = _share_on_table(positions[:, ::-1])
        if exchanged >= _share_on_table(positions) + BETTER:
            horizontal = horizontal[::-1]
    order = [*horizontal, axis]
    if order == [0, 1, 2] and sign > 0:
        return
    if axis == 2 and sign > 0:
        text = "x and y are exchanged: balls fly along x, and bounces are off the table"
    else:
        text = (
            f"{'' if sign > 0 else '-'}{'xyz'[axis]} points up, not z: the ball falls with "
            f"{', '.join(f'{value:.1f}' for value in fall.acceleration)} m/s^2 along x, y, z"
        )
    yield Doubt(text, impossible=True, line=_axes_line(order, sign, measured.flights, setup))


def _up(fall: Fall, flights: Flights) -> tuple[int, int]:
    """Return the axis that gravity acts along, and the sign of its upward direction.

    It is z unless another axis explains the fall far better, and no fewer bounces.
    """
    gravity = fall.acceleration
    axis = int(np.argmax(np.abs(gravity)))
    sign = -int(np.sign(gravity[axis]))
    if (axis, sign) == (2, 1) or (axis != 2 and abs(gravity[axis]) < DOMINANT * abs(gravity[2])):
        return 2, 1
    changes = np.array([contact.after - contact.before for contact in flights.contacts])
    changes = changes.reshape(-1, 3)
    largest = np.abs(changes).max(axis=1, initial=0.0)
    thrown = int((sign * changes[:, axis] >= largest).sum())
    return (2, 1) if thrown < int((changes[:, 2] >= largest).sum()) else (axis, sign)


def _mostly_across(velocities: Floats) -> bool:
    """Return whether (n, 2) or more components of velocities are mostly along the first axis."""
    across, along = np.median(np.abs(velocities), axis=0)[:2]
    return bool(across > DOMINANT * along)


def _share_on_table(positions: Floats) -> float:
    """Return the share of (n, 2) or (n, 3) positions that are on the table."""
    across, along = TABLE_HALF_WIDTH + EDGE, TABLE_HALF_LENGTH + EDGE
    inside = (np.abs(positions[:, 0]) <= across) & (np.abs(positions[:, 1]) <= along)
    return float(inside.mean())


def _axes_line(order: Sequence[int], sign: int, flights: Flights, setup: Setup) -> str:
    """Return the correction: other axes of the columns, or a rotation of right-handed axes.

    Positions do not tell an exchange of two columns from a rotation, which differ by a mirror. Spin
    labels do.
    """
    rotation = np.eye(3)[order]
    if sign > 0 and setup.frame == Frame():
        is_mirror = np.linalg.det(rotation) < 0
        if not (is_mirror and _are_opposite(flights.turned(rotation))):
            return setup.axes_line(order)
    rotation[2] *= sign
    rotation[0] *= np.linalg.det(rotation)
    return setup.frame_line(np.round(rotation), np.zeros(3))


def _impossible_heights(measured: Measured, setup: Setup) -> Iterator[Doubt]:
    """Yield what is wrong with heights: a ball on the table has its centre 20 mm above z = 0."""
    height, share = _usual_height(measured.bounces)
    if share < LEAST_SHARE or abs(height - BALL_RADIUS) < WRONG:
        return
    surface = height - BALL_RADIUS
    from_floor = abs(surface - FLOOR) < NEAR_FLOOR
    offset = np.array([0.0, 0.0, -FLOOR if from_floor else -round(surface, 3)])
    origin = "the floor" if abs(surface - FLOOR) < BAND else "another place"
    text = f"heights are from {origin}, not the table: balls bounce at z = {height:.3f} m, not 0.02"
    yield Doubt(text, impossible=True, line=setup.frame_line(np.eye(3), offset))


def _usual_height(positions: Floats) -> tuple[float, float]:
    """Return the most frequent height of bounces, and the share of bounces near it."""
    heights = positions[:, 2]
    if len(heights) < FEWEST_BOUNCES:
        return BALL_RADIUS, 0.0
    near = np.abs(heights[:, None] - heights) < BAND
    most = near[np.argmax(near.sum(axis=1))]
    return float(np.median(heights[most])), float(most.mean())


@dataclass(frozen=True)
class Lift:
    """What flights with a significant lift say of their labels.

    Attributes:
        cm: C_M that the labels imply, if they are in rad/s.
        opposite: share of the flights whose lift has the opposite direction.
    """

    cm: float
    opposite: float

    @classmethod
    def of(cls, flights: Flights) -> "Lift | None":
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
        return cls(float(np.median(np.abs(cm))), float((cm < 0).mean()))


def _are_opposite(flights: Flights) -> bool:
    """Return whether nearly all labels have the opposite sense of rotation."""
    lift = Lift.of(flights)
    return lift is not None and lift.opposite >= NEARLY_ALL


def _impossible_spins(flights: Flights, setup: Setup) -> Iterator[Doubt]:
    """Yield what is wrong with the unit and the sense of rotation of spin labels."""
    if not len(flights.spins):
        return
    quantile = float(np.quantile(np.linalg.norm(flights.spins, axis=1), QUANTILE))
    present = setup.conversion.units.spin
    unit = _best_unit(flights, quantile, present)
    wrong = []
    if unit != present.lstrip("-"):
        wrong.append(f"are not in {present}, which makes their 90 % quantile {quantile:.3g} rad/s")
    elif quantile > FASTEST_SPIN:
        text = f"spin labels of {quantile:.3g} rad/s are implausible: give their unit"
        yield Doubt(text, impossible=True)
        return
    opposite = _are_opposite(flights)
    if opposite:
        wrong.append("have the opposite sense of rotation: balls curve the other way")
    if wrong:
        sign = "" if opposite == present.startswith("-") else "-"
        text = f"spin labels {' and '.join(wrong)}; {sign + unit}?"
        yield Doubt(text, impossible=True, line=setup.units_line(spin=sign + unit))


def _best_unit(flights: Flights, quantile: float, present: SpinUnit) -> str:
    """Return the unit that explains size and lift, the present one unless it explains neither."""
    lift, stated = Lift.of(flights), present.lstrip("-")
    if lift is None:
        return stated
    too_small = quantile < REVOLUTIONS and lift.cm > LARGEST_CM
    if quantile <= SPINS[1] and not too_small:
        return stated
    misfits = {}
    for unit in UNITS:
        factor = abs(SPIN_UNITS[present]) / SPIN_UNITS[unit]
        cm = lift.cm / factor
        if _within(quantile * factor, SPINS) and _within(cm, CM):
            misfits[unit] = abs(np.log(cm / TYPICAL_CM))
    return min(misfits, key=lambda unit: misfits[unit], default=stated)


def _unusual_falls(measured: Measured) -> Iterator[Doubt]:
    """Yield what is unusual about how balls fly and fall."""
    fall = measured.fall
    if fall is None:
        return
    if _mostly_across(fall.velocities):
        yield Doubt("balls fly along x, across the table: check that y is along it")
    tilt = np.degrees(np.arccos(np.clip(-fall.acceleration[2] / fall.size, -1.0, 1.0)))
    if tilt > TILT:
        yield Doubt(f"gravity and mean lift point {tilt:.0f} degrees off -z: check the axes")
    if not _within(fall.size, LIKELY_FALLS):
        yield Doubt(
            f"the ball falls with {fall.size:.1f} m/s^2 instead of {GRAVITY}, lift included: check "
            "the units"
        )


def _unusual_heights(positions: Floats) -> Iterator[Doubt]:
    """Yield what is unusual about the heights of bounces, and about the plane through them."""
    height, share = _usual_height(positions)
    if share >= LEAST_SHARE and abs(height - BALL_RADIUS) > DOUBTFUL:
        yield Doubt(
            f"balls bounce at z = {1000 * height:.0f} mm; on the table it is 20 mm: check the "
            "origin of heights"
        )
    chosen = positions[np.abs(positions[:, 2] - height) < BAND]
    if len(chosen) < FEWEST_SLOPE:
        return
    terms = np.column_stack([chosen[:, :2] - chosen[:, :2].mean(axis=0), np.ones(len(chosen))])
    slope = float(np.linalg.norm(np.linalg.lstsq(terms, chosen[:, 2])[0][:2]))
    if slope > STEEP:
        yield Doubt(
            f"the heights of bounces rise by {1000 * slope:.0f} mm/m over the table: check the "
            "axes' directions"
        )


def _unusual_samples(measured: Measured) -> Iterator[Doubt]:
    """Yield what is unusual about time stamps and speeds."""
    if all(_is_rounded(track.times) for track in measured.tracks):
        yield Doubt(
            "time stamps are rounded to 1 ms: fast balls move by several millimetres in that time"
        )
    speeds = np.array([track.speed for track in measured.tracks])
    if len(speeds) >= FEWEST_SPEEDS and speeds.std() < SAME_SPEED * speeds.mean():
        yield Doubt(
            f"all shots have about the same speed, {speeds.mean():.1f} m/s: effects that depend on "
            "speed are not identifiable; record several speeds"
        )


def _is_rounded(times: Floats) -> bool:
    """Return whether time stamps are whole milliseconds while frames are not."""
    steps = np.diff(times)
    whole = np.abs(times - np.round(times / ROUNDED) * ROUNDED) < ROUNDING_ERROR
    return bool(whole.all() and np.ptp(steps) > ROUNDED / 2)
