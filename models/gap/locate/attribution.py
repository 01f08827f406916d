"""Attribution of the discrepancy between simulated and measured trajectories.

The discrepancy ``D`` is the sum of parts: what each cause does to predictions, and what no cause
explains. The share of a part is the mean of ``D_part . D`` in that of ``D . D`` over shots, which
sums to one; a part that others more than cancel has none. Shares of flight, table and sensor are
the sums of those of their parts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.horizons import at_horizons
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.locate.covariates import axes, course_frames
from rallygap.models.gap.locate.discrepancy import discrepancy, reliable
from rallygap.models.gap.locate.free_fit import free_discrepancy
from rallygap.models.gap.locate.trends import means_and_margins, trends_against
from rallygap.models.gap.location import Located
from rallygap.models.gap.settings import GapSettings, Question
from rallygap.models.gap.types import PHASES, Phase


@dataclass(frozen=True)
class Part:
    """What one cause, or unexplained structure, adds to the measurements of B shots.

    Attributes:
        identity: of the cause; empty for unexplained structure.
        phase: in which it acts.
        positions: (B, N, 3) m.
        labels: (B, L, 3) in units of the fitted spin.
    """

    identity: str
    phase: Phase
    positions: Floats
    labels: Floats


def locate(fit: RefitResult, question: Question, parts: Sequence[Part]) -> Located | None:
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
    squares = _squares(parts, fit, horizons, settings)
    shares = _shares(squares)
    free = at_horizons(shots, free_discrepancy(fit, question), usable, horizons, settings)
    discrepancies = np.einsum("bij,bhj->bhi", course_frames(fit.linear), free)
    trend = int(np.flatnonzero(counts[kept] >= limits.trend_share * counts.max())[-1])
    places, discrepancy_there = measured[:, kept][:, trend], discrepancies[:, trend]
    return Located(
        horizons,
        np.sqrt(squares.sum(axis=1)),
        {phase: _of_phase(shares, parts, phase) for phase in PHASES},
        {part.identity: share for part, share in zip(parts, shares.T, strict=True)},
        *means_and_margins(discrepancies),
        trends_against(axes(fit.linear, places, limits), discrepancy_there, limits),
        float(horizons[trend]),
    )


def _squares(
    parts: Sequence[Part], fit: RefitResult, horizons: Floats, settings: GapSettings
) -> Floats:
    """Return (H, P) what each part contributes to the mean squared discrepancy, m^2."""
    if not parts:
        return np.zeros((len(horizons), 0))
    linear, noise = fit.linear, fit.noise_estimate
    positions = np.stack([part.positions for part in parts], axis=-1)
    labels = np.stack([part.labels for part in parts], axis=-1)
    effects = discrepancy(linear, noise, positions, labels, settings)
    usable = reliable(linear, noise, settings)
    effects = at_horizons(linear.shots, effects, usable, horizons, settings)
    whole = effects.sum(axis=3, keepdims=True)
    squares: Floats = np.nanmean((effects * whole).sum(axis=2), axis=0)
    return np.maximum(squares, 0.0)


def _shares(squares: Floats) -> Floats:
    shares: Floats = squares / np.maximum(squares.sum(axis=1, keepdims=True), 1e-300)
    return shares


def _of_phase(shares: Floats, parts: Sequence[Part], phase: Phase) -> Floats:
    """Return (H,) the share of one phase."""
    of_phase: Floats = shares[:, [part.phase == phase for part in parts]].sum(axis=1)
    return of_phase
