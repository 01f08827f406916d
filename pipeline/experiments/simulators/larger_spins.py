"""The arena's amateur and club levels with larger spins (part of ``make simulators``).

These levels follow published launches, whose spins were fitted about a simulator with several times
the lift of a real ball. If that made them too small, players spin the ball more than the levels do.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from rallygap.models.arena.levels import Players
from rallygap.models.arena.rallies import EventLog, Rallies
from rallygap.models.arena.truth import draw_truth
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN
from rallygap.models.ball.types import Floats

LEVELS, FACTORS = ("amateur", "club"), (1.0, 1.7)
POINTS = 2000
SEED = 1001  # of a world and its games; not of the arena
SPINS = ("topspin", "attack_topspin", "sidespin", "serve_spin")  # traits
AHEAD = 0.4  # s
MM = 1e3


def larger_spins() -> dict[str, list[dict[str, Any]]]:
    """Return what games are like, by level, a record for each factor on the spins."""
    return {level: [_record(level, factor) for factor in FACTORS] for level in LEVELS}


def _record(level: str, factor: float) -> dict[str, Any]:
    truth, random = draw_truth(SEED), np.random.default_rng(SEED)
    players = Players.draw(level, 2 * POINTS, random)
    spun = replace(players, **{name: factor * getattr(players, name) for name in SPINS})
    log = Rallies(truth, spun, random.integers(2, size=POINTS), random).play()
    launches = _strokes(log)
    sizes = np.linalg.norm(launches[:, SPIN], axis=1)
    return {
        "factor": factor,
        "strokes": len(launches),
        "spin_median": round(float(np.median(sizes)), 1),
        "spin_p95": round(float(np.quantile(sizes, 0.95)), 1),
        "bend_mm": round(MM * float(np.median(_bends(truth.simulator, launches))), 1),
        "strokes_a_point": round(float(log.strokes.mean()), 2),
        "ended_by": _shares(log),
    }


def _strokes(log: EventLog) -> Floats:
    """Return the (B, 9) launches of strokes that are no serves."""
    points, contacts = log.contacts()
    struck = contacts.kinds == "racket"
    points, launches = points[struck], contacts.states[struck]
    rallied: Floats = launches[1:][points[1:] == points[:-1]]
    return rallied


def _bends(simulator: Simulator, launches: Floats) -> Floats:
    """Return by how much lift moves each ball, m, after ``AHEAD`` in free flight."""
    air = simulator.without_surfaces()
    pair = air, air.amended("magnus", cm=0.0)
    flown, straight = (law.fly(launches, [AHEAD]).states[:, 0, POSITION] for law in pair)
    bends: Floats = np.linalg.norm(flown - straight, axis=1)
    return bends


def _shares(log: EventLog) -> Mapping[str, float]:
    """Return how points end, as shares."""
    names, counts = np.unique(log.ended_by, return_counts=True)
    shares = counts / counts.sum()
    return {str(name): round(float(part), 3) for name, part in zip(names, shares, strict=True)}
