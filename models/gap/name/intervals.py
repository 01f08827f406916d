"""Intervals of estimates within physical bounds.

The interval contains the maximum-likelihood values with 95 % of the probability that a normal
distribution has between the bounds.
"""

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from rallygap.models.gap.settings import GapSettings

FARTHEST = 5.0  # standard errors outside its bounds that an estimate counts as, at most (numerics)

Interval = tuple[float, float]


def within(
    estimate: float, margin: float, bounds: Interval, settings: GapSettings
) -> tuple[float, Interval]:
    """Return the maximum-likelihood value within bounds, and its 95 % interval.

    The margin is half the 95 % interval of the estimate without bounds.
    """
    error = max(margin / settings.normal_quantile, 1e-9 * (bounds[1] - bounds[0]))
    low, high = ((end - estimate) / error for end in bounds)
    outside = max(low - FARTHEST, 0.0) + min(high + FARTHEST, 0.0)
    low, high = low - outside, high - outside

    def probability(reach: float) -> float:
        return float(ndtr(min(high, reach)) - ndtr(max(low, -reach)))

    wanted, farthest = settings.confidence * probability(np.inf), max(-low, high)
    half = brentq(lambda reach: probability(reach) - wanted, max(low, -high, 0.0), farthest)
    ends = np.clip([-half, half], low, high) - low
    start, end = np.clip(bounds[0] + error * ends, *bounds)
    value = float(np.clip(estimate, *bounds))
    return value, (min(float(start), value), max(float(end), value))
