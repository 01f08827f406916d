"""Detection scores of contacts against the truth."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.segmentation.settings import ScoringSettings

SCORED_KINDS = ("racket", "table")
UNMATCHED = -1


def in_play(kinds: NDArray[np.str_], y: Floats) -> Bools:
    """Return which contacts of a recording happen while the ball is in play.

    The ball is in play from its launch to a contact with the floor, or to a second bounce on one
    side. That last contact is in play; later ones are not.

    Args:
        kinds: all contacts (k,), in the order of time.
        y: their positions along the table (k,), m.
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


def observable(contacts: Floats, samples: Floats, settings: ScoringSettings) -> Bools:
    """Return which contacts have enough samples on each side, with no other contact between.

    Args:
        contacts: increasing times (k,), s.
        samples: increasing times (n,), s.
        settings: minimum number of samples and width of the window.
    """
    reach, fewest = settings.reach, settings.fewest_samples
    before = np.maximum(contacts - reach, np.concatenate([[-np.inf], contacts[:-1]]))
    after = np.minimum(contacts + reach, np.concatenate([contacts[1:], [np.inf]]))
    earliest, at, latest = (np.searchsorted(samples, times) for times in (before, contacts, after))
    return (at - earliest >= fewest) & (latest - at >= fewest)


def match_contacts(true: Floats, detected: Floats, tolerance: float) -> Integers:
    """Return the index of the detected contact that matches each true one, -1 for none.

    Greedy: the closest pair first, each contact once.

    Args:
        true: times (k,), s.
        detected: times (m,), s.
        tolerance: maximum time difference, s.
    """
    matched = np.full(len(true), UNMATCHED)
    difference = np.abs(true[:, None] - detected[None, :])
    while difference.size and difference.min() < tolerance:
        row, column = np.unravel_index(np.argmin(difference), difference.shape)
        matched[row] = column
        difference[row], difference[:, column] = np.inf, np.inf
    return matched


@dataclass(frozen=True)
class Scored:
    """Scores of the contacts of recordings."""

    # one row per racket contact or table bounce in play: recording_id, kind, speed (m/s, just
    # after; of a bounce the vertical part), observable, detected and error (s, not-a-number where
    # it was not detected)
    true: pd.DataFrame
    false: pd.DataFrame  # one row per false positive: recording_id and kind


def score(
    true: pd.DataFrame, detected: pd.DataFrame, samples: pd.DataFrame, settings: ScoringSettings
) -> Scored:
    """Compare the detected contacts of recordings with the true ones.

    A detected contact matches at most one true one of its kind; all others are false positives,
    also those outside the play.

    Args:
        true: all true contacts: ``recording_id``, ``t``, ``kind``, ``py``, ``vx``, ``vy``, ``vz``.
        detected: detected contacts: ``recording_id``, ``t``, ``kind``.
        samples: measured samples: ``recording_id``, ``t``.
        settings: when a contact counts as detected, and as observable.
    """
    by_id = dict(tuple(detected.groupby("recording_id", sort=False)))
    by_recording = samples.groupby("recording_id", sort=False)["t"]
    measured = {name: times.to_numpy() for name, times in by_recording}
    parts, false = [], []
    # Without any true contact, one empty recording gives tables without rows, but with columns.
    for recording_id, contacts in list(true.groupby("recording_id", sort=False)) or [("", true)]:
        of_recording = by_id.get(recording_id, detected.iloc[:0])
        times = measured.get(recording_id, np.empty(0))
        table = contacts[["recording_id", "kind", "t"]].copy()
        total = np.linalg.norm(contacts[["vx", "vy", "vz"]], axis=1)
        table["speed"] = np.where(contacts["kind"] == "table", contacts["vz"].abs(), total)
        table["observable"] = observable(contacts["t"].to_numpy(), times, settings)
        table["in_play"] = in_play(contacts["kind"].to_numpy(), contacts["py"].to_numpy())
        for kind in SCORED_KINDS:
            of_kind = table[table["kind"] == kind]
            candidates = of_recording[of_recording["kind"] == kind]
            times = candidates["t"].to_numpy()
            matched = match_contacts(of_kind["t"].to_numpy(), times, settings.tolerance)
            of_kind = of_kind.assign(detected=matched != UNMATCHED, error=np.nan)
            hits = of_kind["detected"].to_numpy()
            of_kind.loc[hits, "error"] = times[matched[hits]] - of_kind.loc[hits, "t"]
            parts.append(of_kind[of_kind["in_play"]].drop(columns=["in_play", "t"]))
            unmatched = np.setdiff1d(np.arange(len(candidates)), matched)
            false.append(candidates.iloc[unmatched][["recording_id", "kind"]])
    return Scored(pd.concat(parts, ignore_index=True), pd.concat(false, ignore_index=True))
