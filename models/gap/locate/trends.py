"""Growth: against what the parting of simulated and measured balls grows.

What every shot says of its own parting (free_fit.py) has a sign: along the ball's course, across it
(to the right) and up. Shots are binned by an axis, and the axis is the more telling the more the
bins' means differ. All shots are permuted at random, alike for all axes: an axis' chance is that of
the most telling of all to tell as much when none does. Axes that go together tell the same.

The one axis within a shot is the time since launch. There the mean over all shots counts, and its
chance is that of signs drawn at random, a shot's at once.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from models.ball.types import Floats, Integers
from models.gap.locate.covariates import Axis
from models.gap.location import Growth

TIME = "time since launch"
FEWEST, USUAL = 4, 6  # shots in a bin
MOST_BINS = 5
DRAWS = 2000
BATCH = 500  # permutations at once


def growths(axes: Sequence[Axis], partings: Floats, seed: int = 0) -> tuple[Growth, ...]:
    """Return the growth of partings against axes, the most telling first.

    Args:
        axes: of B shots; those in which they hardly differ are left out.
        partings: (B, 3) m, NaN where a shot does not last as long.
        seed: of the permutations.
    """
    there = np.isfinite(partings).all(axis=1)
    axes = [replace(one, values=one.values[there]) for one in axes]
    partings = partings[there]
    binned = [(axis, bins) for axis in axes if len(bins := _bins(axis)) > 1]
    if not binned:
        return ()
    chances = _chances([bins for _, bins in binned], partings, seed)
    found = [
        _growth(axis, bins, partings, float(chance))
        for (axis, bins), chance in zip(binned, chances, strict=True)
    ]
    return tuple(sorted(found, key=lambda one: (one.p_value, -one.share)))


def over_time(horizons: Floats, partings: Floats, seed: int = 0) -> Growth:
    """Return the growth of (B, H, 3) partings over (H,) s since the launch, NaN beyond a shot."""
    there = np.isfinite(partings)
    filled = np.where(there, partings, 0.0)
    counts = there.sum(axis=0)
    size = np.sqrt((filled**2).sum(axis=0)) + 1e-12
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=(DRAWS, len(filled)))
    largest = np.abs(np.einsum("rb,bhc->rhc", signs, filled, optimize=True) / size).max(axis=(1, 2))
    observed = np.abs(filled.sum(axis=0) / size).max()
    means, errors = _means(partings)
    return Growth(
        axis=TIME,
        unit="ms",
        centres=1000 * horizons,
        kinds=(),
        means=means,
        errors=errors,
        counts=counts[:, 0],
        share=float((counts * means**2).sum() / max((filled**2).sum(), 1e-300)),
        p_value=float((1 + (largest >= observed).sum()) / (1 + DRAWS)),
    )


def _bins(axis: Axis) -> list[Floats]:
    """Return (B,) masks of the bins: kinds, or as many shots in each; small ones are left out."""
    there = np.isfinite(axis.values)
    if axis.kinds:
        masks = [axis.values == kind for kind in range(len(axis.kinds))]
    else:
        count = min(int(there.sum()) // USUAL, MOST_BINS)
        if count < 2:
            return []
        edges = np.quantile(axis.values[there], np.linspace(0, 1, count + 1)[1:-1])
        place = np.searchsorted(edges, axis.values, side="right")
        masks = [there & (place == number) for number in range(count)]
    return [mask.astype(np.float64) for mask in masks if mask.sum() >= FEWEST]


def _growth(axis: Axis, bins: list[Floats], partings: Floats, p_value: float) -> Growth:
    masks = [mask > 0 for mask in bins]
    moments = [_means(partings[mask]) for mask in masks]
    centres = np.array([np.median(axis.values[mask]) for mask in masks])
    return Growth(
        axis=axis.name,
        unit=axis.unit,
        centres=centres,
        kinds=tuple(axis.kinds[int(one)] for one in centres) if axis.kinds else (),
        means=np.array([mean for mean, _ in moments]),
        errors=np.array([error for _, error in moments]),
        counts=np.array([mask.sum() for mask in masks]),
        share=_share(masks, partings),
        p_value=p_value,
    )


def _means(partings: Floats) -> tuple[Floats, Floats]:
    """Return means of (B, ...) partings and half their 95 % intervals, NaN entries aside."""
    count = np.isfinite(partings).sum(axis=0)
    spread = np.nanstd(partings, axis=0, ddof=1)
    half = student.ppf(0.975, np.maximum(count - 1, 1)) * spread / np.sqrt(count)
    return np.nanmean(partings, axis=0), half


def _share(masks: list[NDArray[np.bool_]], partings: Floats) -> float:
    """Return the share of the variance between bins, less what as many bins have by chance."""
    whole = _squares(partings[np.any(masks, axis=0)])
    inside = sum(_squares(partings[mask]) for mask in masks)
    free = int(np.sum(masks)) - len(masks)
    between = whole - inside - (len(masks) - 1) * inside / free
    return max(between, 0.0) / max(whole, 1e-300)


def _squares(partings: Floats) -> float:
    """Return the sum of squares about the mean."""
    return float(((partings - partings.mean(axis=0)) ** 2).sum())


def _chances(binned: list[list[Floats]], partings: Floats, seed: int) -> Floats:
    """Return (A,) the chance that any of A axes, by its bins, is as telling as each of them is."""
    scaled = (partings - partings.mean(axis=0)) / np.maximum(partings.std(axis=0), 1e-12)
    masks = np.stack([mask / np.sqrt(mask.sum()) for bins in binned for mask in bins])
    starts = np.cumsum([0, *(len(bins) for bins in binned[:-1])])
    generator = np.random.default_rng(seed)
    drawn = [
        _telling(masks, starts, scaled[_orders(generator, len(scaled))])
        for _ in range(DRAWS // BATCH)
    ]
    chance, observed = np.concatenate(drawn), _telling(masks, starts, scaled[None])[0]
    mean, spread = chance.mean(axis=0), chance.std(axis=0)
    largest = ((chance - mean) / spread).max(axis=1)
    above = (largest[:, None] >= (observed - mean) / spread).sum(axis=0)
    chances: Floats = (1 + above) / (1 + DRAWS)
    return chances


def _orders(generator: np.random.Generator, count: int) -> Integers:
    orders: Integers = generator.random((BATCH, count)).argsort(axis=1)
    return orders


def _telling(masks: Floats, starts: Integers, partings: Floats) -> Floats:
    """Return (R, A) how much the bins' means of (R, B, 3) partings differ, axis by axis."""
    sums = np.einsum("kb,rbi->rki", masks, partings, optimize=True)
    telling: Floats = np.add.reduceat((sums**2).sum(axis=2), starts, axis=1)
    return telling
