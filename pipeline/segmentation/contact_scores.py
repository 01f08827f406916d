"""Precision and recall of the contacts that segmentation detects in simulated recordings."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from rallygap.models.segmentation.scoring import SCORED_KINDS, Scored, score
from rallygap.models.segmentation.settings import ScoringSettings
from rallygap.models.segmentation.split import recording_groups
from rallygap.pipeline.io.artifacts import read_table
from rallygap.pipeline.io.schemas import CONTACTS, EPISODES, RECORDINGS, check_columns, read_checked

ALL = "all"
COLUMNS = ["kind", "level", "contacts", "precision", "recall", "time error rms (ms)"]
COLUMNS += ["hidden", "hidden recall"]


def score_test_recordings(
    ingested: Path, segmented: Path, true: pd.DataFrame, settings: ScoringSettings
) -> Scored:
    """Compare the contacts detected in the test recordings with the true ones.

    Args:
        ingested: folder with the recordings.
        segmented: folder with episodes and detected contacts.
        true: contacts of all simulated recordings.
        settings: when a contact counts as detected.

    Raises:
        InputError: a table is missing or breaks its data contract.
    """
    episodes = read_checked(segmented / "episodes.parquet", EPISODES)
    testing = episodes.loc[episodes["split"] == "test", "recording_id"].drop_duplicates()
    detected = read_checked(segmented / "contacts.parquet", CONTACTS)
    path = ingested / "recordings.parquet"
    check_columns(path, RECORDINGS)
    samples = read_table(path, ["recording_id", "t"])
    samples = samples[samples["recording_id"].isin(testing)]
    true, detected = (table[table["recording_id"].isin(testing)] for table in (true, detected))
    return score(true, detected, samples, settings)


def contacts_table(scored: Scored) -> pd.DataFrame:
    """Return precision and recall of each kind of contact, by players' level and for all levels."""
    groups = recording_groups(scored.true["recording_id"])
    false_groups = recording_groups(scored.false["recording_id"])
    rows = []
    for kind in SCORED_KINDS:
        true, false = scored.true["kind"] == kind, scored.false["kind"] == kind
        for level in [*sorted(groups[true].unique()), ALL]:
            of_level = true & ((groups == level) | (level == ALL))
            false_positives = false & ((false_groups == level) | (level == ALL))
            if of_level.any():
                row = _row(scored.true[of_level], int(false_positives.sum()))
                rows.append({"kind": kind, "level": level, **row})
    return pd.DataFrame(rows, columns=COLUMNS)


def contact_metrics(table: pd.DataFrame) -> dict[str, Any]:
    """Return the recall of each kind, over all levels."""
    overall = table[table["level"] == ALL].set_index("kind")["recall"]
    return {str(kind): {"recall": round(recall, 4)} for kind, recall in overall.dropna().items()}


def _row(contacts: pd.DataFrame, false_positives: int) -> dict[str, Any]:
    observable, hidden = contacts[contacts["observable"]], contacts[~contacts["observable"]]
    true_positives = int(observable["detected"].sum())
    return {
        "contacts": len(observable),
        "precision": _share(true_positives, true_positives + false_positives),
        "recall": _share(true_positives, len(observable)),
        "time error rms (ms)": 1e3 * np.sqrt((observable["error"] ** 2).mean()),
        "hidden": len(hidden),
        "hidden recall": _share(int(hidden["detected"].sum()), len(hidden)),
    }


def _share(part: int, whole: int) -> float:
    return part / whole if whole else np.nan
