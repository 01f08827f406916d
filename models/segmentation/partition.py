"""Optimal partition of samples into ballistic arcs and outliers (changepoint detection).

The cost of an arc is the negative log-likelihood of its samples under the flight filter, a fixed
cost for each sample that the filter rejects as an outlier, and a fixed cost for the contact at its
start. Dynamic programming finds the partition of least total cost. One pass of the filter gives the
costs of an arc for all its possible ends.

A rejected sample does not change the filter, so an outlier costs nothing else, except among the
first two samples of an arc, before the filter can predict. Every arc is therefore tried with
several second samples.
"""

import numpy as np

from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.segmentation.flight import (
    compiled,
    initialise,
    negative_log_likelihood,
    predict_covariance,
    predict_mean,
    update,
)

FEWEST_SAMPLES = 3  # two samples fit an arc exactly
SECOND_SAMPLES = 3  # how many candidates for an arc's second sample are tried
OUTLIERS_IN_A_ROW = 12  # at most; after more an arc has ended
LONGEST_ARC = 2.0  # s; a lob of 4.9 m. Keeps the work linear where a ball lies still.

UNUSED = -1  # a sample that is in no arc


@compiled
def filter_arc(
    t: Floats,
    x: Floats,
    first: int,
    second: int,
    noise: float,
    outlier_cost: float,
    costs: Floats,
    used: Bools,
) -> int:
    """Filter the arc that starts with the samples ``first`` and ``second``.

    Args:
        t: times (n,), s.
        x: positions (n, 3), m.
        first: the arc's first sample.
        second: its second; those between are outliers.
        noise: standard deviation of a sample in each axis, m.
        outlier_cost: nats.
        costs: filled from ``first`` on with the cost of the arc that ends with that sample;
            infinite where it cannot end.
        used: filled from ``first`` on with whether the sample is used.

    Returns:
        One past the last sample of the longest arc.
    """
    mean, covariance = np.empty((3, 3)), np.empty((3, 3))
    initialise(mean, covariance, x[first], noise)
    total, accepted, rejected = 0.0, 1, 0
    used[first] = True
    for k in range(first + 1, len(t)):
        costs[k], used[k] = np.inf, False
        if t[k] - t[first] > LONGEST_ARC or rejected > OUTLIERS_IN_A_ROW:
            return k
        predict_mean(mean, t[k] - t[k - 1])
        predict_covariance(covariance, t[k] - t[k - 1])
        loss = negative_log_likelihood(mean, covariance, x[k], noise)
        if k < second or (k > second and loss > outlier_cost):
            total, rejected = total + outlier_cost, rejected + 1
            continue
        update(mean, covariance, x[k], noise)
        used[k] = True
        total, accepted, rejected = total + loss, accepted + 1, 0
        if accepted >= FEWEST_SAMPLES:
            costs[k] = total
    return len(t)


@compiled
def partition(
    t: Floats, x: Floats, noise: float, contact_cost: float, outlier_cost: float
) -> tuple[Integers, Integers, Integers]:
    """Partition samples into the arcs of least total cost.

    Args:
        t: increasing times (n,), s.
        x: positions (n, 3), m.
        noise: standard deviation of a sample in each axis, m.
        contact_cost: cost of one more arc, nats.
        outlier_cost: cost of one sample called an outlier, nats.

    Returns:
        The first, second and last sample of every arc, in the order of time.
    """
    n = len(t)
    best = np.full(n + 1, np.inf)  # least cost of all samples before this one
    best[0] = 0.0
    starts = np.full(n + 1, UNUSED)  # of the arc that ends there in the best partition
    seconds = np.full(n + 1, UNUSED)
    costs, used = np.empty(n), np.empty(n, dtype=np.bool_)
    for i in range(n):
        if best[i] + outlier_cost < best[i + 1]:
            best[i + 1], starts[i + 1] = best[i] + outlier_cost, UNUSED
        for second in range(i + 1, min(i + 1 + SECOND_SAMPLES, n)):
            beyond = filter_arc(t, x, i, second, noise, outlier_cost, costs, used)
            for k in range(second, beyond):
                if best[i] + contact_cost + costs[k] < best[k + 1]:
                    best[k + 1] = best[i] + contact_cost + costs[k]
                    starts[k + 1], seconds[k + 1] = i, second
    return _trace(starts, seconds)


@compiled
def _trace(starts: Integers, seconds: Integers) -> tuple[Integers, Integers, Integers]:
    firsts, middles, lasts = [0][:0], [0][:0], [0][:0]
    end = len(starts) - 1
    while end > 0:
        if starts[end] == UNUSED:
            end -= 1
            continue
        firsts.append(starts[end])
        middles.append(seconds[end])
        lasts.append(end - 1)
        end = starts[end]
    return np.array(firsts[::-1]), np.array(middles[::-1]), np.array(lasts[::-1])
