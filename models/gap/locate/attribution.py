"""Locate: how far simulated and measured balls part, where that arises, against what it grows.

A phase (flight, table, sensor) is *replaced by the measured one* by freeing all that may act in it:
the catalogue's effects there, whatever the simulator says of them, and the omnibus basis
(basis.py), with the values that the shots say. A prediction with all three replaced leaves noise
and scatter alone; one by the simulator parts from it by ``D``, the sum of what each phase does to
it. The mean of ``D . D`` over shots is shared out by what it falls by when a phase is replaced,
averaged over all orders of replacing the three; for the square of a sum this is the mean of
``D_phase . D``. So what two phases do to one another is halved between them, and a table that is
wrong counts from the bounce on.

Which phases are wrong at all is weighed first (phases.py). Where shots tell them apart, one
explanation stays; where they do not, the shares are the explanations' mean. What resembles neither
the catalogue nor the basis passes for scatter or noise, and is in no share.
"""

from collections.abc import Sequence

import numpy as np

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.fit.horizons import at_horizons
from models.gap.fit.refit import Refitted
from models.gap.locate.covariates import axes, courses
from models.gap.locate.discrepancy import parting, reliable
from models.gap.locate.free_fit import free_parting
from models.gap.locate.phase_selection import Candidates
from models.gap.locate.trends import growths, over_time
from models.gap.location import Located
from models.gap.types import PHASES, Places

HORIZONS: Floats = np.linspace(0.025, 0.6, 24)  # s
FEWEST, FEW = 5, 0.25  # shots at a horizon, and their share of those at most
MOST = 2 / 3  # of them reach the horizon at which growth is looked at
UNLIKELY = 1e-3  # weight below which an explanation is left out
NOTHING = 0.5  # weight of no term at all, from which on nothing parts


def locate(found: Refitted, nominal: Simulator, withheld: Sequence[str] = ()) -> Located | None:
    """Locate the gap between shots and a simulator; None if too few shots are long enough.

    Args:
        found: the shots about a simulator nearby, such as the nominal one, refitted or not.
        nominal: the simulator in question.
        withheld: effects that are not in the catalogue.
    """
    shots, usable = found.linear.shots, reliable(found.linear, found.components)
    measured = at_horizons(shots, shots.positions, usable, HORIZONS)
    reaching = np.isfinite(measured[..., 0]).sum(axis=0)
    reached = (reaching >= FEWEST) & (reaching >= FEW * reaching.max())
    if not reached.any():
        return None
    horizons = HORIZONS[reached]
    squares = _squares(Candidates.of(found, nominal, withheld), found, horizons)
    partings = np.einsum(
        "bij,bhj->bhi",
        courses(found.linear),
        at_horizons(shots, free_parting(found, nominal), usable, horizons),
    )
    looked_at = int(np.flatnonzero(reaching[reached] >= MOST * reaching.max())[-1])
    places, then = measured[:, reached][:, looked_at], partings[:, looked_at]
    return Located(
        horizons,
        np.sqrt(squares.sum(axis=1)),
        dict(zip(PHASES, _shares(squares).T, strict=True)),
        over_time(horizons, partings),
        growths(axes(found.linear, places), then),
        float(horizons[looked_at]),
    )


def _squares(candidates: Candidates, found: Refitted, horizons: Floats) -> Floats:
    """Return (H, P) what each phase has in the mean square of partings, m^2."""
    squares = np.zeros((len(horizons), len(PHASES)))
    likely = candidates.explanations()
    for terms, weight in likely.items():
        if terms and weight > UNLIKELY and likely[()] < NOTHING:
            squares += weight * _explained(candidates, terms, found, horizons)
    return np.maximum(squares, 0.0)


def _explained(candidates: Candidates, terms: Places, found: Refitted, horizons: Floats) -> Floats:
    linear = candidates.linear
    of_phase = [[candidates.phases[k] == phase for phase in PHASES] for k in terms]
    values = candidates.values(terms)[:, None] * np.array(of_phase)
    places = [linear.own + k for k in terms]
    positions, labels = linear.positions[..., places] @ values, linear.labels[..., places] @ values
    parts = parting(linear, found.components, positions, labels)
    usable = reliable(linear, found.components)
    parts = at_horizons(linear.shots, parts, usable, horizons)
    whole = parts.sum(axis=3, keepdims=True)
    squares: Floats = np.nanmean((parts * whole).sum(axis=2), axis=0)
    return squares


def _shares(squares: Floats) -> Floats:
    shares: Floats = squares / np.maximum(squares.sum(axis=1, keepdims=True), 1e-300)
    return shares
