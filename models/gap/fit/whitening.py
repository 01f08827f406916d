"""Whitening: rows of positions in the metric of their noise, compiled.

The innovations of a Kalman filter that follows the slow error are summed up in products.
"""

from pathlib import Path

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.support.compilation import compiler


@compiler([Path(__file__)])
def shrink_along(rows: Floats, directions: Floats, reduction: Floats) -> Floats:
    """Return (B, N, 3, C) rows r - c d d' r, for (B, N, 3) directions d and (B, N) reductions c."""
    count, length, _, width = rows.shape
    out = np.empty_like(rows)
    for b in range(count):
        for i in range(length):
            x, y, z = directions[b, i]
            for c in range(width):
                along = x * rows[b, i, 0, c] + y * rows[b, i, 1, c] + z * rows[b, i, 2, c]
                along *= reduction[b, i]
                out[b, i, 0, c] = rows[b, i, 0, c] - along * x
                out[b, i, 1, c] = rows[b, i, 1, c] - along * y
                out[b, i, 2, c] = rows[b, i, 2, c] - along * z
    return out


@compiler([Path(__file__)])
def white_products(
    rows: Floats,
    directions: Floats,
    reduction: Floats,
    times: Floats,
    weights: Floats,
    sizes: tuple[float, float, float],
) -> tuple[Floats, Floats]:
    """Return (B, C, C) products of white (B, N, 3, C) rows, and (B,) logarithms of determinants.

    Args:
        rows: columns of positions.
        directions: (B, N, 3) along which they are shrunk.
        reduction: (B, N) by how much.
        times: (B, N) s.
        weights: (B, N) by which white variances are divided; zero where a sample is not used.
        sizes: white noise and slow error, m, and the time in which the latter changes, s.
    """
    count, length, _, width = rows.shape
    white, slow, slow_time = sizes
    products = np.empty((count, width, width))
    determinants = np.zeros(count)
    expected, innovations = np.zeros((3, width)), np.empty((length, 3, width))
    for b in range(count):
        expected[:] = 0.0
        used = 0
        variance, last = slow * slow, times[b, 0]
        for i in range(length):
            if weights[b, i] == 0.0:
                continue
            memory = np.exp(-(times[b, i] - last) / slow_time)
            last = times[b, i]
            variance = memory * memory * variance + (1.0 - memory * memory) * slow * slow
            total = variance + white * white / weights[b, i]
            determinants[b] += 3.0 * np.log(total)
            scale, gain = 1.0 / np.sqrt(total), variance / total
            _innovate(
                rows[b, i],
                directions[b, i],
                reduction[b, i],
                (memory, gain, scale),
                expected,
                innovations[used],
            )
            used += 1
            variance *= 1.0 - gain
        white_rows = innovations[:used].reshape(3 * used, width)
        products[b] = white_rows.T @ white_rows
    return products, determinants


@compiler([Path(__file__)])
def _innovate(
    rows: Floats,
    direction: Floats,
    reduction: float,
    sizes: tuple[float, float, float],
    expected: Floats,
    innovations: Floats,
) -> None:
    """Put the white innovations of (3, C) rows into ``innovations``; update what is expected.

    The sizes are the memory of the slow error, the gain of the filter and the scale of whitening.
    """
    x, y, z = direction
    memory, gain, scale = sizes
    for c in range(rows.shape[1]):
        along = reduction * (x * rows[0, c] + y * rows[1, c] + z * rows[2, c])
        for axis in range(3):
            before = memory * expected[axis, c]
            innovation = rows[axis, c] - along * direction[axis] - before
            innovations[axis, c] = scale * innovation
            expected[axis, c] = before + gain * innovation
