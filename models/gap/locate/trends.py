"""Trends: against which covariate the discrepancy grows.

Shots are binned by a covariate; its statistic is the spread of the bins' means. The null
distribution comes from permutations of the shots, the same for all covariates, and a p-value is
that of the largest of all standardised statistics (max-T, Westfall and Young 1993).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from rallygap.models.ball.types import Floats, Integers
from rallygap.models.gap.locate.covariates import Axis
from rallygap.models.gap.location import Growth
from rallygap.models.gap.settings import LocateSettings

BATCH = 500  # permutations at once


def trends_against(
    axes: Sequence[Axis], discrepancies: Floats, settings: LocateSettings
) -> tuple[Growth, ...]:
    """Return the growth of (B, 3) discrepancies, m, with each covariate, smallest p-value first.

    Shots whose discrepancy is NaN are left out, and covariates in which shots hardly differ.
    """
    there = np.isfinite(discrepancies).all(axis=1)
    axes = [replace(axis, values=axis.values[there]) for axis in axes]
    discrepancies = discrepancies[there]
    binned = [(axis, bins) for axis in axes if len(bins := _bins(axis, settings)) > 1]
    if not binned:
        return ()
    p_values = _p_values([bins for _, bins in binned], discrepancies, settings.permutations)
    found = [
        _growth(axis, bins, discrepancies, float(p_value))
        for (axis, bins), p_value in zip(binned, p_values, strict=True)
    ]
    return tuple(sorted(found, key=lambda growth: (growth.p_value, -growth.share)))


def means_and_margins(discrepancies: Floats) -> tuple[Floats, Floats]:
    """Return means of (B, ...) discrepancies and half their 95 % intervals, NaN aside."""
    count = np.isfinite(discrepancies).sum(axis=0)
    spread = np.nanstd(discrepancies, axis=0, ddof=1)
    half = student.ppf(0.975, np.maximum(count - 1, 1)) * spread / np.sqrt(count)
    return np.nanmean(discrepancies, axis=0), half


def _bins(axis: Axis, settings: LocateSettings) -> list[Floats]:
    """Return (B,) masks of the bins: kinds, or as many shots in each; small ones are left out."""
    there = np.isfinite(axis.values)
    if axis.kinds:
        masks = [axis.values == kind for kind in range(len(axis.kinds))]
    else:
        count = min(int(there.sum()) // settings.typical_bin_shots, settings.max_bins)
        if count < 2:
            return []
        edges = np.quantile(axis.values[there], np.linspace(0, 1, count + 1)[1:-1])
        place = np.searchsorted(edges, axis.values, side="right")
        masks = [there & (place == number) for number in range(count)]
    return [mask.astype(np.float64) for mask in masks if mask.sum() >= settings.min_bin_shots]


def _growth(axis: Axis, bins: list[Floats], discrepancies: Floats, p_value: float) -> Growth:
    masks = [mask > 0 for mask in bins]
    moments = [means_and_margins(discrepancies[mask]) for mask in masks]
    centres = np.array([np.median(axis.values[mask]) for mask in masks])
    return Growth(
        covariate=axis.name,
        unit=axis.unit,
        centres=centres,
        kinds=tuple(axis.kinds[int(number)] for number in centres) if axis.kinds else (),
        means=np.array([mean for mean, _ in moments]),
        margins=np.array([margin for _, margin in moments]),
        share=_share(masks, discrepancies),
        p_value=p_value,
    )


def _share(masks: list[NDArray[np.bool_]], discrepancies: Floats) -> float:
    """Return the share of the variance between bins, less what as many bins have by chance."""
    whole = _squares(discrepancies[np.any(masks, axis=0)])
    inside = sum(_squares(discrepancies[mask]) for mask in masks)
    free = int(np.sum(masks)) - len(masks)
    between = whole - inside - (len(masks) - 1) * inside / free
    return max(between, 0.0) / max(whole, 1e-300)


def _squares(discrepancies: Floats) -> float:
    """Return the sum of squares about the mean."""
    return float(((discrepancies - discrepancies.mean(axis=0)) ** 2).sum())


def _p_values(binned: list[list[Floats]], discrepancies: Floats, draws: int) -> Floats:
    """Return (A,) p-values of A axes by their bins, adjusted for their number (max-T)."""
    scaled = (discrepancies - discrepancies.mean(axis=0)) / np.maximum(
        discrepancies.std(axis=0), 1e-12
    )
    masks = np.stack([mask / np.sqrt(mask.sum()) for bins in binned for mask in bins])
    starts = np.cumsum([0, *(len(bins) for bins in binned[:-1])])
    generator = np.random.default_rng(0)
    drawn = [
        _spread(masks, starts, scaled[_orders(generator, len(scaled))])
        for _ in range(draws // BATCH)
    ]
    p_value, observed = np.concatenate(drawn), _spread(masks, starts, scaled[None])[0]
    mean, spread = p_value.mean(axis=0), p_value.std(axis=0)
    largest = ((p_value - mean) / spread).max(axis=1)
    above = (largest[:, None] >= (observed - mean) / spread).sum(axis=0)
    p_values: Floats = (1 + above) / (1 + draws)
    return p_values


def _orders(generator: np.random.Generator, count: int) -> Integers:
    return generator.random((BATCH, count)).argsort(axis=1)


def _spread(masks: Floats, starts: Integers, discrepancies: Floats) -> Floats:
    """Return (R, A) how much the bins' means of (R, B, 3) discrepancies differ, by axis."""
    sums = np.einsum("kb,rbi->rki", masks, discrepancies, optimize=True)
    return np.add.reduceat((sums**2).sum(axis=2), starts, axis=1)
