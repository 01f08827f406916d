"""The report on round trips: the largest differences by kind of list and parameter."""

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from rallygap.pipeline.simulator_scenes.named import LISTS, named_of, named_summary
from rallygap.pipeline.simulator_scenes.plain_scene import KINDS, Kind
from rallygap.pipeline.simulator_scenes.results import results
from rallygap.pipeline.simulator_scenes.round_trip import RoundTrip, round_trip

TARGET = 0.01  # relative difference that a parameter may have


def round_trips(scratch: Path) -> dict[str, Any]:
    """Return how far lists differ that go into scenes and come back by audits.

    Args:
        scratch: folder of what a killed run leaves to the next one.
    """
    trips = {(name, k): f"{name}-{k}" for name, one in KINDS.items() for k in range(one.lists)}
    makers = {trip: partial(_trip, KINDS[name], k) for (name, k), trip in trips.items()}
    made = results(scratch, makers, "round trips")
    extra = {f"named-{k}": partial(named_of, k) for k in range(LISTS)}
    return {
        "target": TARGET,
        "kinds": {
            name: summary(one, [RoundTrip(**made[trips[name, k]]) for k in range(one.lists)])
            for name, one in KINDS.items()
        },
        "without_attribute": named_summary(results(scratch, extra, "lists without attributes")),
    }


def summary(kind: Kind, trips: Sequence[RoundTrip]) -> dict[str, Any]:
    """Return the part of the report on round trips of a kind."""
    differing = sorted({name for one in trips for name in one.differences})
    added = sorted({name for one in trips for name in one.added})
    return {
        "lists": len(trips),
        "step_ms": float(f"{1e3 * kind.step:.4g}"),
        "contact_ms": float(f"{1e3 * kind.contact:.4g}"),
        "slip_damping": kind.slip,
        "parameters": {name: _parameter(name, trips) for name in differing},
        "also_found": {name: _also_found(name, trips) for name in added},
    }


def _trip(kind: Kind, number: int) -> dict[str, Any]:
    return asdict(round_trip(kind, kind.effects(number)))


def _parameter(name: str, trips: Sequence[RoundTrip]) -> dict[str, Any]:
    having = [one for one in trips if name in one.differences]
    largest = max(one.differences[name] for one in having)
    sizes = [abs(one.wanted[name]) for one in having]
    return {
        "lists": len(having),
        "smallest": float(f"{min(sizes):.4g}"),
        "largest": float(f"{max(sizes):.4g}"),
        "largest_difference": largest,
        "within_target": largest <= TARGET,
    }


def _also_found(name: str, trips: Sequence[RoundTrip]) -> dict[str, Any]:
    values = [one.added[name] for one in trips if name in one.added]
    return {"lists": len(values), "largest": float(f"{max(values, key=abs):.2g}")}
