"""Where one recording breaks: its flights, the contacts between them, and the gaps."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from models.segmentation.contacts import Contact, meet, moved
from models.segmentation.partition import UNUSED, follow, partition
from models.segmentation.residual import flight_errors
from models.segmentation.settings import SegmentSettings
from models.segmentation.smoothing import smooth

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Paths of two arcs of three samples, carried over 50 ms of dropouts, still meet this closely.
FARTHEST_MISS = 0.05  # m


@dataclass(frozen=True)
class Cuts:
    """A recording in flights.

    Attributes:
        flight: (n,) the flight that each sample belongs to, counted from 0; -1 for the samples
            between two gaps that are too few to tell a flight.
        velocity: (n, 3) of the smooth path, m/s; not-a-number where ``flight`` is -1.
        outlier: (n,) whether the path leaves the sample out.
        error: (n,) distance from the smoothest flight through the samples that are no outliers, m;
            not-a-number where ``flight`` is -1.
        contacts: by the number of the flight that begins with it. A flight without one begins the
            recording or follows a gap.
    """

    flight: Indices
    velocity: Array
    outlier: Mask
    error: Array
    contacts: dict[int, Contact] = field(default_factory=dict)

    @property
    def flights(self) -> int:
        """How many flights there are."""
        return int(self.flight.max(initial=UNUSED)) + 1


@dataclass(frozen=True)
class _Arc:
    first: int
    last: int
    used: Mask  # (last + 1 - first,)
    means: Array  # (last + 1 - first, 3, 3)


def cut(t: Array, x: Array, settings: SegmentSettings) -> Cuts:
    """Find the flights and contacts of a recording.

    Args:
        t: growing times (n,), s.
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
            _enter(cuts, t[here], begin, arcs, settings)
    for flight in range(cuts.flights):
        own = np.flatnonzero(cuts.flight == flight)
        cuts.error[own] = flight_errors(t[own], x[own], cuts.velocity[own], ~cuts.outlier[own])
    return cuts


def _arcs(t: Array, x: Array, settings: SegmentSettings) -> list[_Arc]:
    noise, outlier_cost = settings.noise, settings.outlier_cost
    bounds = partition(t, x, noise, settings.contact_cost, outlier_cost)
    arcs = []
    for first, second, last in zip(*bounds, strict=True):
        times, positions = t[first : last + 1], x[first : last + 1]
        costs, used = np.empty(len(times)), np.empty(len(times), dtype=np.bool_)
        follow(times, positions, 0, second - first, noise, outlier_cost, costs, used)
        arcs.append(_Arc(first, last, used, smooth(times, positions, used, noise)))
    return arcs


def _meeting(t: Array, before: _Arc, after: _Arc) -> Contact:
    # The sample next to a contact fits either arc: the contact may lie half a sample beyond it.
    earliest = 0.5 * (t[before.last - 1] + t[before.last])
    latest = 0.5 * (t[after.first] + t[after.first + 1])
    ends = (before.means[-1], t[before.last]), (after.means[0], t[after.first])
    return meet(*ends, earliest, latest)


def _enter(cuts: Cuts, t: Array, begin: int, arcs: list[_Arc], settings: SegmentSettings) -> None:
    """Enter the arcs of a run of samples, the first of them number ``begin``, into ``cuts``."""
    flight = cuts.flights
    meetings = [_meeting(t, *pair) for pair in pairwise(arcs)]
    owners = np.searchsorted([meeting.time for meeting in meetings], t, side="right")
    for number, arc in enumerate(arcs):
        if number and _is_contact(meetings[number - 1], settings):
            flight += 1
            cuts.contacts[flight] = meetings[number - 1]
        cuts.outlier[begin + arc.first : begin + arc.last + 1] = ~arc.used
        own = np.flatnonzero(owners == number)
        cuts.flight[begin + own] = flight
        cuts.velocity[begin + own] = _velocities(arc, t, own)


def _is_contact(meeting: Contact, settings: SegmentSettings) -> bool:
    jumps = meeting.speed_change > settings.smallest_jump
    return meeting.miss < FARTHEST_MISS and (jumps or meeting.grazes)


def _velocities(arc: _Arc, t: Array, own: Indices) -> Array:
    nearest = np.clip(own, arc.first, arc.last)
    velocities: Array = arc.means[nearest - arc.first, 1]
    for k in np.flatnonzero(own != nearest):  # beyond the arc's ends
        velocities[k] = moved(arc.means[nearest[k] - arc.first], t[own[k]] - t[nearest[k]])[1]
    return velocities
