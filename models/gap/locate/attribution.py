"""Attribution of the discrepancy between simulated and measured trajectories.

The discrepancy ``D`` is the sum of what each phase (flight, table, sensor) contributes: the
catalogue's effects there and the omnibus terms (term_library.py). The mean of ``D . D`` over shots
is shared out by how much it falls when a phase is freed, averaged over all orders of freeing the
three (Shapley's value); for the square of a sum this is the mean of ``D_phase . D``. Which phases
are wrong at all is selected first (phase_selection.py); where several explanations remain, the
shares are their weighted mean.
"""

import numpy as np

from models.ball.types import Floats
from models.gap.fit.horizons import at_horizons
from models.gap.fit.refit import RefitResult
from models.gap.locate.covariates import axes, course_frames
from models.gap.locate.discrepancy import discrepancy, reliable
from models.gap.locate.free_fit import free_discrepancy
from models.gap.locate.phase_selection import Candidates
from models.gap.locate.trends import means_and_margins, trends_against
from models.gap.location import Located
from models.gap.settings import Question
from models.gap.types import PHASES, Places


def locate(fit: RefitResult, question: Question) -> Located | None:
    """Locate the gap between shots and the nominal simulator, from a fit about a simulator nearby.

    It is None if too few shots are long enough.
    """
    settings, limits = question.settings, question.settings.locate
    shots, usable = fit.linear.shots, reliable(fit.linear, fit.noise_estimate, settings)
    horizons = np.array(limits.horizons)
    measured = at_horizons(shots, shots.positions, usable, horizons, settings)
    counts = np.isfinite(measured[..., 0]).sum(axis=0)
    kept = (counts >= limits.min_shots) & (counts >= limits.min_share * counts.max())
    if not kept.any():
        return None
    horizons = horizons[kept]
    squares = _squares(Candidates.of(fit, question), fit, horizons)
    free = at_horizons(shots, free_discrepancy(fit, question), usable, horizons, settings)
    discrepancies = np.einsum("bij,bhj->bhi", course_frames(fit.linear), free)
    trend = int(np.flatnonzero(counts[kept] >= limits.trend_share * counts.max())[-1])
    places, discrepancy_there = measured[:, kept][:, trend], discrepancies[:, trend]
    return Located(
        horizons,
        np.sqrt(squares.sum(axis=1)),
        dict(zip(PHASES, _shares(squares).T, strict=True)),
        *means_and_margins(discrepancies),
        trends_against(axes(fit.linear, places, limits), discrepancy_there, limits),
        float(horizons[trend]),
    )


def _squares(candidates: Candidates, fit: RefitResult, horizons: Floats) -> Floats:
    """Return (H, P) the share of each phase in the mean squared discrepancy, m^2."""
    squares = np.zeros((len(horizons), len(PHASES)))
    settings = candidates.evidence.settings.locate
    weights = candidates.explanations()
    for terms, weight in weights.items():
        if terms and weight > settings.min_weight and weights[()] < settings.no_gap_weight:
            squares += weight * _explained(candidates, terms, fit, horizons)
    return np.maximum(squares, 0.0)


def _explained(candidates: Candidates, terms: Places, fit: RefitResult, horizons: Floats) -> Floats:
    linear, settings = candidates.linear, candidates.evidence.settings
    of_phase = [[candidates.phases[k] == phase for phase in PHASES] for k in terms]
    values = candidates.values(terms)[:, None] * np.array(of_phase)
    places = [linear.nuisance_count + k for k in terms]
    positions, labels = linear.positions[..., places] @ values, linear.labels[..., places] @ values
    parts = discrepancy(linear, fit.noise_estimate, positions, labels, settings)
    usable = reliable(linear, fit.noise_estimate, settings)
    parts = at_horizons(linear.shots, parts, usable, horizons, settings)
    whole = parts.sum(axis=3, keepdims=True)
    squares: Floats = np.nanmean((parts * whole).sum(axis=2), axis=0)
    return squares


def _shares(squares: Floats) -> Floats:
    shares: Floats = squares / np.maximum(squares.sum(axis=1, keepdims=True), 1e-300)
    return shares
