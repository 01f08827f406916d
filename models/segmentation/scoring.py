"""How well segmentation finds contacts, where the truth is known."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.segmentation.settings import ScoringSettings

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

SCORED_KINDS = ("racket", "table")
UNMATCHED = -1


def in_play(kinds: NDArray[np.str_], y: Floats) -> Mask:
    """Return which contacts of a recording happen while the ball is in play.

    It is from its launch until it touches the floor, or the table a second time on one side; that
    last touch belongs to the play. What it does afterwards is nobody's business.

    Args:
        kinds: of all contacts (k,), in the order of time.
        y: where along the table they happen (k,), m.
    """
    playing = np.zeros(len(kinds), dtype=bool)
    alive, half = False, 0.0
    for k, kind in enumerate(kinds):
        alive = alive or kind == "launch"
        playing[k] = alive
        if kind in ("launch", "racket"):
            half = 0.0
        elif kind == "table":
            alive, half = alive and np.sign(y[k]) != half, np.sign(y[k])
        elif kind == "floor":
            alive = False
    return playing


def can_be_seen(contacts: Floats, samples: Floats, settings: ScoringSettings) -> Mask:
    """Return at which contacts enough samples lie near on each side, before the next contact.

    Args:
        contacts: growing times (k,), s.
        samples: growing times (n,), s.
        settings: how many are enough, and what is near.
    """
    reach, fewest = settings.reach, settings.fewest_samples
    before = np.maximum(contacts - reach, np.concatenate([[-np.inf], contacts[:-1]]))
    after = np.minimum(contacts + reach, np.concatenate([contacts[1:], [np.inf]]))
    earliest, at, latest = (np.searchsorted(samples, times) for times in (before, contacts, after))
    seen: Mask = (at - earliest >= fewest) & (latest - at >= fewest)
    return seen


def matches(true: Floats, found: Floats, tolerance: float) -> Indices:
    """Return for every true contact which found one is it, -1 where none is.

    Pairs are taken the closest first, and each contact once.

    Args:
        true: times (k,), s.
        found: times (m,), s.
        tolerance: between the two, at most, s.
    """
    matched = np.full(len(true), UNMATCHED)
    apart = np.abs(true[:, None] - found[None, :])
    while apart.size and apart.min() < tolerance:
        row, column = np.unravel_index(np.argmin(apart), apart.shape)
        matched[row] = column
        apart[row], apart[:, column] = np.inf, np.inf
    return matched


@dataclass(frozen=True)
class Scored:
    """How the contacts of recordings were found.

    Attributes:
        true: one row a racket contact or table bounce in play: ``recording_id``, ``kind``,
            ``speed`` (m/s, just after; of a bounce the vertical part), ``seen``, ``found`` and
            ``error`` (s, not-a-number where it was not found).
        false: one row a found contact that is none: ``recording_id`` and ``kind``.
    """

    true: pd.DataFrame
    false: pd.DataFrame


def score(
    true: pd.DataFrame, found: pd.DataFrame, samples: pd.DataFrame, settings: ScoringSettings
) -> Scored:
    """Compare the contacts that were found in recordings with the true ones.

    A found contact that matches a true one of its kind counts once, with that one; whatever else
    was found is false, wherever it lies.

    Args:
        true: all true contacts: ``recording_id``, ``t``, ``kind``, ``py``, ``vx``, ``vy``, ``vz``.
        found: those found: ``recording_id``, ``t``, ``kind``.
        samples: when the ball was measured: ``recording_id``, ``t``.
        settings: what counts as found, and as seen.
    """
    found_ones = dict(tuple(found.groupby("recording_id", sort=False)))
    by_recording = samples.groupby("recording_id", sort=False)["t"]
    measured = {name: times.to_numpy() for name, times in by_recording}
    parts, false = [], []
    # Without any truth, one recording without contacts: tables without rows, but with columns.
    for recording_id, contacts in list(true.groupby("recording_id", sort=False)) or [("", true)]:
        own = found_ones.get(recording_id, found.iloc[:0])
        table = _described(contacts, measured.get(recording_id, np.empty(0)), settings)
        for kind in SCORED_KINDS:
            of_kind, candidates = table[table["kind"] == kind], own[own["kind"] == kind]
            times = candidates["t"].to_numpy()
            matched = matches(of_kind["t"].to_numpy(), times, settings.tolerance)
            parts.append(_outcomes(of_kind, times, matched))
            unmatched = np.setdiff1d(np.arange(len(candidates)), matched)
            false.append(candidates.iloc[unmatched][["recording_id", "kind"]])
    return Scored(pd.concat(parts, ignore_index=True), pd.concat(false, ignore_index=True))


def _described(contacts: pd.DataFrame, samples: Floats, settings: ScoringSettings) -> pd.DataFrame:
    """Return what the score needs to know of a recording's true contacts."""
    table = contacts[["recording_id", "kind", "t"]].copy()
    total = np.linalg.norm(contacts[["vx", "vy", "vz"]], axis=1)
    table["speed"] = np.where(contacts["kind"] == "table", contacts["vz"].abs(), total)
    table["seen"] = can_be_seen(contacts["t"].to_numpy(), samples, settings)
    table["in_play"] = in_play(contacts["kind"].to_numpy(), contacts["py"].to_numpy())
    return table


def _outcomes(contacts: pd.DataFrame, found: Floats, matched: Indices) -> pd.DataFrame:
    table = contacts.assign(found=matched != UNMATCHED, error=np.nan)
    hits = table["found"].to_numpy()
    table.loc[hits, "error"] = found[matched[hits]] - table.loc[hits, "t"]
    return table[table["in_play"]].drop(columns=["in_play", "t"])
