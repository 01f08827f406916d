"""Latency: how long a frame takes from its message to the forecast's."""

import numpy as np

BINS = np.array([0.0, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0, np.inf])  # ms
WIDTH = 40  # characters of the largest bar


class Latencies:
    """Counts latencies in bins of a hundredth of a millisecond, in constant memory."""

    def __init__(self) -> None:
        self._counts = np.zeros(5001, dtype=np.int64)  # the last one: 50 ms and more

    def add(self, seconds: float) -> None:
        """Count one frame."""
        self._counts[min(int(seconds * 1e5), len(self._counts) - 1)] += 1

    @property
    def frames(self) -> int:
        """How many frames were counted."""
        return int(self._counts.sum())

    def percentile(self, share: float) -> float:
        """Return the latency in ms that a share of the frames, in per cent, do not exceed."""
        reached = np.cumsum(self._counts) >= share / 100 * self.frames
        return round(0.01 * (int(np.argmax(reached)) + 1), 2)

    def histogram(self) -> list[str]:
        """Return the lines of a histogram."""
        edges = (0.01 * np.arange(len(self._counts))).round(2)
        counts = np.histogram(edges, BINS, weights=self._counts)[0]
        return [_bar(*row, counts.max()) for row in zip(BINS[:-1], BINS[1:], counts, strict=True)]


def summary(latencies: Latencies) -> str:
    """Return one line on how fast frames were answered."""
    if not latencies.frames:
        return "no frame"
    p50, p99, p999 = (latencies.percentile(share) for share in (50, 99, 99.9))
    return f"{latencies.frames} frames; a forecast took {p50} ms (p50), {p99} (p99), {p999} (p99.9)"


def _bar(low: float, high: float, count: float, largest: float) -> str:
    name = f"{low:g} to {high:g} ms" if np.isfinite(high) else f"{low:g} ms and more"
    bar = "█" * round(WIDTH * count / largest) if largest else ""
    return f"{name:>16} {int(count):8d} {bar}"
