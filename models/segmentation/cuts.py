"""Flights of one recording, the contacts between them, and the gaps."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.integrate import cumulative_trapezoid

from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.segmentation.contacts import Contact, closest_approach, extrapolated
from rallygap.models.segmentation.flight import DRAG, smooth
from rallygap.models.segmentation.partition import UNUSED, filter_arc, partition
from rallygap.models.segmentation.settings import SegmentSettings

# Paths of two arcs of three samples, extrapolated over 50 ms of dropouts, approach this closely.
MAX_DISTANCE = 0.05  # m


@dataclass(frozen=True)
class Cuts:
    """Segmentation of one recording."""

    # (n,) the flight that each sample belongs to, counted from 0; -1 for the samples between two
    # gaps that are too few for a flight
    flight: Integers
    velocity: Floats  # (n, 3) of the smoothed path, m/s; not-a-number where flight is -1
    outlier: Bools  # (n,) whether the sample is an outlier
    # (n,) distance from the least-squares flight (flight_residuals), m; not-a-number where flight
    # is -1
    residual: Floats
    # by the number of the flight that starts with it. A flight without one starts the recording or
    # follows a gap
    contacts: dict[int, Contact] = field(default_factory=dict)

    @property
    def flights(self) -> int:
        """Number of flights."""
        return int(self.flight.max(initial=UNUSED)) + 1


@dataclass(frozen=True)
class _Arc:
    first: int
    last: int
    used: Bools  # (last + 1 - first,)
    means: Floats  # (last + 1 - first, 3, 3)


def cut(t: Floats, x: Floats, settings: SegmentSettings) -> Cuts:
    """Segment a recording into flights and contacts.

    Args:
        t: increasing times (n,), s.
        x: positions (n, 3), m.
        settings: noise, costs and limits.
    """
    n = len(t)
    unknown = np.full(n, np.nan)
    cuts = Cuts(np.full(n, UNUSED), np.full((n, 3), np.nan), np.ones(n, dtype=bool), unknown)
    gaps = np.flatnonzero(np.diff(t) > settings.longest_gap) + 1
    for begin, end in zip([0, *gaps], [*gaps, n], strict=True):
        here = slice(begin, end)
        arcs = _arcs(t[here], np.ascontiguousarray(x[here]), settings)
        if arcs:
            _assign(cuts, t[here], begin, arcs, settings)
    for flight in range(cuts.flights):
        rows = np.flatnonzero(cuts.flight == flight)
        used = ~cuts.outlier[rows]
        cuts.residual[rows] = flight_residuals(t[rows], x[rows], cuts.velocity[rows], used)
    return cuts


def _arcs(t: Floats, x: Floats, settings: SegmentSettings) -> list[_Arc]:
    noise, outlier_cost = settings.noise, settings.outlier_cost
    bounds = partition(t, x, noise, settings.contact_cost, outlier_cost)
    arcs = []
    for first, second, last in zip(*bounds, strict=True):
        times, positions = t[first : last + 1], x[first : last + 1]
        costs, used = np.empty(len(times)), np.empty(len(times), dtype=np.bool_)
        filter_arc(times, positions, 0, second - first, noise, outlier_cost, costs, used)
        arcs.append(_Arc(first, last, used, smooth(times, positions, used, noise)))
    return arcs


def _assign(
    cuts: Cuts, t: Floats, offset: int, arcs: list[_Arc], settings: SegmentSettings
) -> None:
    """Assign consecutive samples, the first of them number ``offset``, to the flights of arcs."""
    flight = cuts.flights
    contacts: list[Contact] = []
    for before, after in pairwise(arcs):
        # The sample next to a contact fits either arc: it may lie half a sample beyond it.
        earliest = 0.5 * (t[before.last - 1] + t[before.last])
        latest = 0.5 * (t[after.first] + t[after.first + 1])
        ends = (before.means[-1], t[before.last]), (after.means[0], t[after.first])
        contacts.append(closest_approach(*ends, earliest, latest))
    owner = np.searchsorted([contact.time for contact in contacts], t, side="right")
    for number, arc in enumerate(arcs):
        if number and _is_contact(contacts[number - 1], settings):
            flight += 1
            cuts.contacts[flight] = contacts[number - 1]
        cuts.outlier[offset + arc.first : offset + arc.last + 1] = ~arc.used
        members = np.flatnonzero(owner == number)
        cuts.flight[offset + members] = flight
        nearest = np.clip(members, arc.first, arc.last)
        cuts.velocity[offset + members] = arc.means[nearest - arc.first, 1]
        for k in np.flatnonzero(members != nearest):  # extrapolated beyond the ends of the arc
            since = t[members[k]] - t[nearest[k]]
            state = extrapolated(arc.means[nearest[k] - arc.first], since)
            cuts.velocity[offset + members[k]] = state[1]


def _is_contact(contact: Contact, settings: SegmentSettings) -> bool:
    is_step = contact.speed_change > settings.smallest_jump
    return contact.distance < MAX_DISTANCE and (is_step or contact.is_grazing)


def flight_residuals(t: Floats, x: Floats, velocity: Floats, used: Bools) -> Floats:
    """Return each sample's distance from a path with nominal drag and one constant acceleration.

    The constant stands for gravity, lift and a wrong drag coefficient. It cannot follow a contact,
    which the flight filter with its white jerk can.

    Args:
        t: times (n,), s.
        x: positions (n, 3), m.
        velocity: (n, 3), m/s, for the drag.
        used: (n,) the samples that the path is fitted to.

    Returns:
        Distances (n,), m.
    """
    drag = -DRAG * np.linalg.norm(velocity, axis=1, keepdims=True) * velocity
    slowed = cumulative_trapezoid(drag, t, axis=0, initial=0)
    displaced = cumulative_trapezoid(slowed, t, axis=0, initial=0)
    parabola = np.vander(t - t[0], 3)
    coefficients = np.linalg.lstsq(parabola[used], (x - displaced)[used])[0]
    return np.linalg.norm(x - displaced - parabola @ coefficients, axis=1)
