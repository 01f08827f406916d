"""Posterior predictive checks: sizes of held-out shots over those of the fitted model.

A model of the errors that does not fit makes every test of causes wrong. So the residuals of
held-out shots, the errors of predictions and of landings, and the errors of labels are compared
with what the fitted model expects of them. Errors of labels and the scatter of bounces are part of
the model whatever their size, and are compared with the largest plausible ones.
"""

from collections.abc import Iterator
from typing import Literal

import numpy as np
from scipy.stats import chi2

from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.projection import eliminate_nuisance
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.fit.trajectory import KICK_SIZE
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.verdict import Check
from rallygap.models.gap.verify.bootstrap import drawn_shots, interval
from rallygap.models.gap.verify.prediction_error import Errors

AFTER, FLOOR = 1, 2  # rows of errors
LABELS: Literal["labels"] = "labels"
BOUNCES: Literal["bounces"] = "bounces"
NOT_OF_PATHS = (LABELS, BOUNCES)  # however large these are, the model has their size


def checks(
    fit: RefitResult, verification: RefitResult, found: Errors | None, settings: GapSettings
) -> tuple[Check, ...]:
    """Return the checks for which there are enough shots; those of ``verification`` are held out.

    ``fit`` is of the shots that the causes were named by.
    """
    made = [_residuals(verification, settings)]
    if found is not None:
        made += list(_predictions(found, settings))
    made += [*_labels(verification, settings), *_bounces(fit, settings)]
    return tuple(check for check in made if check is not None)


def _residuals(verification: RefitResult, settings: GapSettings) -> Check | None:
    """Compare the residuals of whole shots with the noise: roots of squares a degree of freedom."""
    linear, noise = verification.linear, verification.noise_estimate
    left = eliminate_nuisance(noise.gram_matrices, linear.nuisance_count)
    weighty = noise.shot_weights > settings.locate.min_shot_weight
    rows = 3 * (noise.weights.sum(axis=1) + linear.labelled.sum(axis=1)) - STATE_SIZE
    squares = (left.misfit / np.maximum(rows, 1.0))[weighty]
    return _check("residuals", np.stack([squares, np.ones(len(squares))])[..., None], settings)


def _predictions(found: Errors, settings: GapSettings) -> Iterator[Check | None]:
    pairs = [AFTER, FLOOR]
    reached = np.isfinite(found.squares[0]).sum(axis=0) >= settings.verify.min_checked
    yield _check("prediction", found.squares[pairs][..., reached], settings)
    landed = found.landings[pairs][:, np.isfinite(found.landings).all(axis=(0, 2)), :1]
    yield _check("landing", landed, settings)


def _labels(verification: RefitResult, settings: GapSettings) -> Iterator[Check]:
    """Compare the errors of labels with the spins: beyond half of them they say nothing."""
    if verification.linear.labelled.any():
        size = verification.noise_estimate.noise.label_error
        allowed = settings.verify.allowed[LABELS]
        yield Check(name=LABELS, ratio=size, interval=(size, size), allowed=allowed)


def _bounces(fit: RefitResult, settings: GapSettings) -> Iterator[Check]:
    """Compare the scatter of the restitution with the largest one that tables have shown."""
    known, inner = fit.noise_estimate, slice(STATE_SIZE, fit.linear.nuisance_count)
    bounced = fit.linear.positions[..., inner][..., ::KICK_SIZE].any(axis=(1, 2))
    count = float(known.shot_weights @ bounced.sum(axis=1))
    if count < settings.verify.min_bounces:
        return
    size, tail = known.noise.scatter[0], (1 - settings.confidence) / 2
    low, high = size * np.sqrt(count / chi2.isf([tail, 1 - tail], count))
    allowed = settings.verify.allowed[BOUNCES]
    yield Check(name=BOUNCES, ratio=size, interval=(float(low), float(high)), allowed=allowed)


def _check(name: str, squares: Floats, settings: GapSettings) -> Check | None:
    """Return the ratio of (2, B, H) measured and expected squares; None with too few shots.

    Sizes are medians over shots: one ball that is predicted to miss the table decides nothing.
    """
    shots = int(np.isfinite(squares).all(axis=(0, 2)).sum()) if squares.shape[2] else 0
    if shots < settings.verify.min_checked:
        return None
    measured, expected = _root_medians(squares[:, None])[:, 0]
    rows = drawn_shots(squares.shape[1], settings.verify.bootstrap_draws)
    drawn = _root_medians(squares[:, rows]).T
    return Check.model_validate(
        {
            "name": name,
            "ratio": float(measured / expected),
            "interval": interval(drawn[:, 0] / drawn[:, 1], settings.confidence),
            "allowed": settings.verify.allowed[name],
        }
    )


def _root_medians(squares: Floats) -> Floats:
    """Return (2, D) roots of medians over shots of (2, D, B, H) squares, means over horizons."""
    roots: Floats = np.sqrt(np.nanmedian(squares, axis=2)).mean(axis=2)
    return roots
