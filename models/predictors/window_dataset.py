"""Training windows as tensors: each episode once on the 200 Hz grid, windows as its slices.

Windows overlap almost entirely, so they are not stored: a batch is gathered from the tracks by one
indexing operation, in the memory of the training device.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from rallygap.models.predictors.protocol import FUTURE, HISTORY, TICK
from rallygap.models.predictors.windows import (
    MIN_FUTURE,
    MIN_OBSERVED,
    Episode,
    cut_windows,
    measured_at,
    observed_at,
)

Indices = NDArray[np.int64]

BEFORE = torch.arange(1 - HISTORY, 1)
AFTER = torch.arange(1, FUTURE + 1)
GRID_TOLERANCE = 1e-6  # s
ROWS = ("history", "mask", "future", "measured")  # fields of tracks


@dataclass(frozen=True)
class Tracks:
    """The concatenated tracks of E episodes.

    Attributes:
        history: (N, 6) measured position (m) and spin (rad/s), outliers included.
        mask: (N, 6) where they were measured.
        future: (N, 9) measured position, velocity (m/s) and spin, without outliers.
        measured: (N, 9) where they were measured.
        anchors: (A,) rows at which a window's history may end, by episode.
        bounds: (E + 1,) offsets of each episode's anchors.
    """

    history: Tensor
    mask: Tensor
    future: Tensor
    measured: Tensor
    anchors: Indices
    bounds: Indices

    @property
    def episodes(self) -> int:
        """Number of episodes."""
        return len(self.bounds) - 1

    def to(self, device: torch.device) -> "Tracks":
        """Return the tracks with their rows in the memory of a device."""
        return replace(self, **{name: getattr(self, name).to(device) for name in ROWS})

    def windows(self, anchors: Indices) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return history (B, 12, 6), mask, future (B, 60, 9) and measured at ``anchors``."""
        ends = torch.from_numpy(anchors).to(self.history.device)[:, None]
        before, after = ends + BEFORE.to(ends.device), ends + AFTER.to(ends.device)
        return self.history[before], self.mask[before], self.future[after], self.measured[after]

    def draw_anchors(self, episodes: Indices, random: np.random.Generator) -> Indices:
        """Return one anchor of each of ``episodes``, at random."""
        first, last = self.bounds[episodes], self.bounds[episodes + 1]
        return self.anchors[random.integers(first, last)]


def build_tracks(episodes: Sequence[Episode]) -> Tracks:
    """Return the tracks of episodes; those without any window are left out.

    An episode on the 200 Hz grid becomes one track. Any other is cut into windows, one ending at
    every measured sample, and each window becomes a short track: a common grid would interpolate
    a history towards samples that are measured after it.

    Raises:
        ValueError: no episode has a window.
    """
    parts = [_track(episode) for episode in episodes]
    parts = [(rows, anchors) for rows, anchors in parts if len(anchors)]
    if not parts:
        raise ValueError("no episode has a window to train on")
    columns = zip(*(rows for rows, _ in parts), strict=True)
    starts = np.cumsum([0, *(len(rows[0]) for rows, _ in parts)])
    anchors = [own + start for (_, own), start in zip(parts, starts, strict=False)]
    return Tracks(
        **{
            name: torch.cat([_tensor(part) for part in column])
            for name, column in zip(ROWS, columns, strict=True)
        },
        anchors=np.concatenate(anchors),
        bounds=np.cumsum([0, *(len(own) for own in anchors)]),
    )


def _track(episode: Episode) -> tuple[list[NDArray[Any]], Indices]:
    """Return the rows of an episode, named as in ``ROWS``, and its anchors."""
    ticks = (episode.times - episode.times[0]) / TICK
    nearest = np.round(ticks).astype(int)
    if np.abs(ticks - nearest).max() * TICK < GRID_TOLERANCE:
        return _whole(episode, nearest)
    cut = cut_windows(episode, every=TICK)
    ahead, behind = ((0, 0), (0, FUTURE), (0, 0)), ((0, 0), (HISTORY, 0), (0, 0))
    past, future = (cut.history.states, cut.history.mask), (cut.future, cut.measured)
    rows = [np.pad(part, ahead).reshape(-1, 6) for part in past]
    rows += [np.pad(part, behind).reshape(-1, 9) for part in future]
    return rows, HISTORY - 1 + (HISTORY + FUTURE) * np.arange(len(cut))


def _whole(episode: Episode, ticks: Indices) -> tuple[list[NDArray[Any]], Indices]:
    """Return rows and anchors of an episode whose samples lie on the grid, at ``ticks``."""
    last = int(ticks[-1])
    grid = episode.times[0] + TICK * np.arange(last + 1)
    # Exact grid times, so that rounded time stamps are not interpolated with the next sample.
    episode = replace(episode, times=grid[ticks])
    rows = [*observed_at(episode, grid), *measured_at(episode, grid)]
    enough = np.convolve(rows[1][:, :3].all(axis=1), np.ones(HISTORY, dtype=int))[: last + 1]
    usable = (ticks >= HISTORY - 1) & (ticks <= last - round(MIN_FUTURE / TICK))
    usable &= enough[ticks] >= MIN_OBSERVED
    beyond = ((0, FUTURE), (0, 0))  # unmeasured padding
    return [np.pad(part, beyond) for part in rows], ticks[usable]


def _tensor(rows: NDArray[Any]) -> Tensor:
    """Return rows as a tensor; floats in single precision."""
    return torch.from_numpy(rows.astype(rows.dtype if rows.dtype == bool else np.float32))
