"""Shots: times and positions as the sensor gave them, and spin labels where there are any."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rallygap.models.ball.types import Floats
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.types import Bools

# Limits of plausible shots: m from the table, s in one shot, rad/s.
FARTHEST, LONGEST, FASTEST = 1e4, 20.0, 1e5


@dataclass(frozen=True)
class Shots:
    """B shots of at most N samples and L spin labels each.

    Padding repeats a shot's last sample; padded labels are NaN.

    Attributes:
        times: (B, N) s on the sensor's clock, rising within a shot.
        positions: (B, N, 3) m.
        valid: (B, N) which of them are samples and which padding.
        label_times: (B, L) s on the same clock, NaN where there is no label.
        labels: (B, L, 3) rad/s, NaN where there is none.
        names: (B,) of the shots.
        groups: (B,) the recording that each is from.
        shared: (B, N, R) functions of place, of which errors that all shots share are sums; R is
            zero where there are none (camera_field.py).
    """

    times: Floats
    positions: Floats
    valid: Bools
    label_times: Floats
    labels: Floats
    names: NDArray[Any]
    groups: NDArray[Any]
    shared: Floats

    @classmethod
    def from_arrays(
        cls,
        times: Sequence[ArrayLike],
        positions: Sequence[ArrayLike],
        labels: Sequence[ArrayLike] | None = None,
        label_times: Sequence[ArrayLike] | None = None,
        names: Sequence[Hashable] | None = None,
        groups: Sequence[Hashable] | None = None,
    ) -> "Shots":
        """Build shots from one array a shot.

        Rows of labels with a NaN are dropped. A label repeated in successive rows is one
        measurement, of the spin at the first of these rows.

        Args:
            times: (N_s,) s for every shot s.
            positions: (N_s, 3) m.
            labels: (L_s, 3) rad/s; none where left out.
            label_times: (L_s,) s; those of the samples where left out.
            names: of the shots; their numbers where left out.
            groups: their recordings; each its own where left out.

        Raises:
            ValueError: shapes that do not fit, positions that are not finite, no sample in a shot,
                times that do not rise, or implausible numbers.
        """
        count = len(times)
        all_times = [np.asarray(t, dtype=np.float64) for t in times]
        places = [np.asarray(p, dtype=np.float64).reshape(-1, 3) for p in positions]
        if labels is None:
            labels, label_times = [np.empty((0, 3))] * count, [np.empty(0)] * count
        when = all_times if label_times is None else label_times
        spins = [_distinct(t, w) for t, w in zip(when, labels, strict=True)]
        _check(all_times, places, [w for _, w in spins])
        shot_names = list(range(count)) if names is None else list(names)
        return cls(
            _padded(all_times, repeat=True),
            _padded(places, repeat=True),
            _padded([np.ones(len(t)) for t in all_times]) == 1.0,
            _padded([t for t, _ in spins]),
            _padded([w for _, w in spins]),
            np.array(shot_names),
            np.array(shot_names if groups is None else list(groups)),
            np.zeros((count, max(map(len, all_times), default=0), 0)),
        )

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, index: Any) -> "Shots":
        """Return the shots at ``index``: a slice, an array of numbers or a mask."""
        return Shots(*(getattr(self, field.name)[index] for field in fields(self)))

    @property
    def labelled(self) -> Bools:
        """(B, L) where there is a spin label."""
        return np.isfinite(self.label_times)

    def corrected(self, coefficients: Floats) -> "Shots":
        """Return shots less the shared errors of (3 R,) coefficients, m, R for each axis."""
        errors = self.shared @ coefficients.reshape(3, -1).T
        return replace(self, positions=self.positions - errors)

    def without_shared(self) -> "Shots":
        """Return shots that share no errors."""
        return replace(self, shared=self.shared[..., :0])


def held_out(shots: Shots, settings: GapSettings) -> Bools:
    """Return (B,) which shots are held out: one in ``settings.verify.held_out``.

    Whole recordings are held out if there are at least twice ``settings.verify.held_out`` of them.
    """
    one_in = settings.verify.held_out
    groups, member = np.unique(shots.groups.astype(str), return_inverse=True)
    units = member if len(groups) >= 2 * one_in else np.arange(len(shots))
    order = np.random.default_rng(0).permutation(units.max() + 1)
    return np.asarray(order[units] % one_in == 0)


def spread_evenly(count: int, most: int) -> NDArray[np.int64]:
    """Return places of at most so many of ``count`` shots, spread evenly."""
    return np.unique(np.linspace(0, count - 1, most).round().astype(np.int64))


def _distinct(times: ArrayLike, labels: ArrayLike) -> tuple[Floats, Floats]:
    when = np.asarray(times, dtype=np.float64)
    spins = np.asarray(labels, dtype=np.float64).reshape(-1, 3)
    if len(when) != len(spins):
        raise ValueError(f"{len(spins)} labels at {len(when)} times")
    there = np.isfinite(spins).all(axis=1)
    when, spins = when[there], spins[there]
    new = np.ones(len(spins), dtype=bool)
    new[1:] = (spins[1:] != spins[:-1]).any(axis=1)
    return when[new], spins[new]


def _check(times: list[Floats], positions: list[Floats], labels: list[Floats]) -> None:
    for number, (t, p, w) in enumerate(zip(times, positions, labels, strict=True)):
        if len(t) == 0 or len(t) != len(p):
            raise ValueError(f"shot {number} has {len(t)} times and {len(p)} positions")
        if not (np.isfinite(t).all() and np.isfinite(p).all()):
            raise ValueError(f"shot {number} has a time or a position that is not finite")
        if (np.diff(t) <= 0).any():
            raise ValueError(f"the times of shot {number} do not rise")
        if np.abs(p).max() > FARTHEST or t[-1] - t[0] > LONGEST:
            raise ValueError(f"shot {number} goes beyond {FARTHEST:g} m or {LONGEST:g} s")
        if np.abs(w).max(initial=0.0) > FASTEST:
            raise ValueError(f"a spin label of shot {number} is above {FASTEST:g} rad/s")


def _padded(parts: list[Floats], repeat: bool = False) -> Floats:
    """Return (B, longest, ...): NaN beyond the end of a part, or its last entry repeated."""
    longest = max((len(part) for part in parts), default=0)
    shape = parts[0].shape[1:] if parts else ()
    padded = np.full((len(parts), longest, *shape), np.nan)
    for row, part in zip(padded, parts, strict=True):
        row[: len(part)] = part
        if repeat:
            row[len(part) :] = part[-1]
    return padded
