"""The best partition of a run of samples into ballistic arcs and outliers.

Every arc has a cost: the surprise of its samples under the flight filter, an outlier's fixed cost
for each one that the filter refuses, and the fixed cost of the contact that began it. Dynamic
programming finds the partition of least cost among all of them; an arc's costs for all its possible
ends come from one pass of the filter.

A refused sample leaves the filter as it was, so an outlier costs nothing else, except among an
arc's first two samples, which the filter has nothing to hold against. Every arc is therefore tried
with several second samples.
"""

import numpy as np
from numpy.typing import NDArray

from models.segmentation.compiled import compiled
from models.segmentation.flight import drift, spread, start, surprise, update

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

FEWEST_SAMPLES = 3  # two samples always lie on some arc
SECOND_SAMPLES = 3  # how many candidates for an arc's second sample are tried
OUTLIERS_IN_A_ROW = 12  # at most; after more an arc has ended
LONGEST_ARC = 2.0  # s; a lob of 4.9 m. Keeps the work linear where a ball lies still.

UNUSED = -1  # a sample that is in no arc


@compiled
def follow(
    t: Array,
    x: Array,
    begin: int,
    second: int,
    noise: float,
    outlier_cost: float,
    costs: Array,
    used: Mask,
) -> int:
    """Follow the arc that begins with the samples ``begin`` and ``second``.

    Args:
        t: times (n,), s.
        x: positions (n, 3), m.
        begin: the arc's first sample.
        second: its second; those between are outliers.
        noise: standard deviation of a sample in each axis, m.
        outlier_cost: nats.
        costs: filled from ``begin`` on with the cost of the arc that ends with that sample;
            infinite where it cannot end.
        used: filled from ``begin`` on with whether the arc takes the sample in.

    Returns:
        One past the last sample of the longest arc.
    """
    mean, covariance = np.empty((3, 3)), np.empty((3, 3))
    start(mean, covariance, x[begin], noise)
    total, taken, refused = 0.0, 1, 0
    used[begin] = True
    for k in range(begin + 1, len(t)):
        costs[k], used[k] = np.inf, False
        if t[k] - t[begin] > LONGEST_ARC or refused > OUTLIERS_IN_A_ROW:
            return k
        drift(mean, t[k] - t[k - 1])
        spread(covariance, t[k] - t[k - 1])
        news = surprise(mean, covariance, x[k], noise)
        if k < second or (k > second and news > outlier_cost):
            total, refused = total + outlier_cost, refused + 1
            continue
        update(mean, covariance, x[k], noise)
        used[k] = True
        total, taken, refused = total + news, taken + 1, 0
        if taken >= FEWEST_SAMPLES:
            costs[k] = total
    return len(t)


@compiled
def partition(
    t: Array, x: Array, noise: float, contact_cost: float, outlier_cost: float
) -> tuple[Indices, Indices, Indices]:
    """Cut a run of samples into the arcs of least total cost.

    Args:
        t: growing times (n,), s.
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
    begins = np.full(n + 1, UNUSED)  # of the arc that ends there in the best partition
    seconds = np.full(n + 1, UNUSED)
    costs, used = np.empty(n), np.empty(n, dtype=np.bool_)
    for i in range(n):
        if best[i] + outlier_cost < best[i + 1]:
            best[i + 1], begins[i + 1] = best[i] + outlier_cost, UNUSED
        for second in range(i + 1, min(i + 1 + SECOND_SAMPLES, n)):
            beyond = follow(t, x, i, second, noise, outlier_cost, costs, used)
            for k in range(second, beyond):
                if best[i] + contact_cost + costs[k] < best[k + 1]:
                    best[k + 1] = best[i] + contact_cost + costs[k]
                    begins[k + 1], seconds[k + 1] = i, second
    return _trace(begins, seconds)


@compiled
def _trace(begins: Indices, seconds: Indices) -> tuple[Indices, Indices, Indices]:
    first, second, last = [0][:0], [0][:0], [0][:0]
    end = len(begins) - 1
    while end > 0:
        if begins[end] == UNUSED:
            end -= 1
            continue
        first.append(begins[end])
        second.append(seconds[end])
        last.append(end - 1)
        end = begins[end]
    return np.array(first[::-1]), np.array(second[::-1]), np.array(last[::-1])
