"""Counts of spin labels: how many there are, and how many of them shots use."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from rallygap.pipeline.io.episodes import MeasuredEpisode
from rallygap.pipeline.io.schemas import SPIN_COLUMNS
from rallygap.pipeline.io.source_manifest import SourceRecord


@dataclass(frozen=True)
class LabelCounts:
    """Spin labels of recordings; a label for a whole recording counts once.

    Attributes:
        read: how many the files have.
        implausible: how many of them are refused.
        used: how many are in shots.
    """

    read: int
    implausible: int
    used: int

    @property
    def elsewhere(self) -> int:
        """How many are plausible but in no shot."""
        return self.read - self.implausible - self.used


def count_labels(
    parts: Sequence[pd.DataFrame], record: SourceRecord, chosen: Sequence[MeasuredEpisode]
) -> LabelCounts:
    """Count the labels of a source.

    Args:
        parts: its recordings, without refused rows and labels.
        record: of the source.
        chosen: the shots.
    """
    labelled = [part["recording_id"][part[SPIN_COLUMNS].notna().all(axis=1)] for part in parts]
    used = pd.Series(
        np.repeat(
            [member.recording_id for member in chosen],
            [np.isfinite(member.episode.spins).all(axis=1).sum() for member in chosen],
        ),
        dtype="str",
    )
    kept = pd.concat(labelled)
    if record.spin == "per_recording":
        kept, used = kept.drop_duplicates(), used.drop_duplicates()
    implausible = sum(refused.count for refused in record.labels_refused.values())
    return LabelCounts(len(kept) + implausible, implausible, len(used))
