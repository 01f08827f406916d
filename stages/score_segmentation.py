"""Score the contacts that segmentation found against the truth of simulated recordings."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from models.segmentation.scoring import SCORED_KINDS, Scored, score
from models.segmentation.split import recording_groups
from pipeline.io.artifacts import read_row_groups
from pipeline.io.schemas import (
    CONTACTS,
    EPISODES,
    RECORDINGS,
    TRUE_CONTACTS,
    check_columns,
    read_checked,
)
from pipeline.runtime.console import warn
from pipeline.runtime.stage_run import StageRun, run_stage
from pipeline.segmentation.figures.contact_scores import contact_scores_figure

ALL = "all"
COLUMNS = ["kind", "level", "contacts", "precision", "recall", "time error rms (ms)"]
COLUMNS += ["hidden", "hidden recall"]


def score_segmentation(run: StageRun) -> None:
    """Compare contacts found in test recordings with the true ones, by players' level."""
    settings = run.params.score_segmentation
    scored = _scored(run)
    table = pd.DataFrame(_rows(scored), columns=COLUMNS)
    if table.empty:
        warn("no simulated recording is in the test split: there are no contacts to score")
    run.write_metrics(_metrics(table))
    run.add_table(
        table,
        "contacts",
        title="Contacts found",
        caption=f"Contacts of test recordings while the ball is in play. Found means: of the same "
        f"kind, within {1e3 * settings.tolerance:g} ms. Precision and recall are of contacts with "
        f"{settings.fewest_samples} samples within {1e3 * settings.reach:g} ms on each side and "
        "no other contact between; hidden are the others.",
    )
    run.add_figure(
        contact_scores_figure(scored.true[scored.true["seen"]]),
        "contact_scores",
        title="Contacts found",
        caption="Racket contacts and bounces of test recordings: errors of the times that "
        "segmentation finds, also over the speed; a cross is a contact that it misses.",
    )


def _scored(run: StageRun) -> Scored:
    episodes = read_checked(run.input("segment", "episodes.parquet"), EPISODES)
    testing = episodes.loc[episodes["split"] == "test", "recording_id"].drop_duplicates()
    true = read_checked(run.input("ingest", "true_contacts.parquet"), TRUE_CONTACTS)
    found = read_checked(run.input("segment", "contacts.parquet"), CONTACTS)
    path = run.input("ingest", "recordings.parquet")
    check_columns(path, RECORDINGS)
    samples = pd.concat(
        part.loc[part["recording_id"].isin(testing), ["recording_id", "t"]]
        for part in read_row_groups(path)
    )
    run.log_input("true_contacts", run.input("ingest", "true_contacts.parquet"), len(true))
    true, found = (table[table["recording_id"].isin(testing)] for table in (true, found))
    return score(true, found, samples, run.params.score_segmentation)


def _rows(scored: Scored) -> Iterator[dict[str, Any]]:
    """Yield one row a kind and level, and one for all levels."""
    groups = recording_groups(scored.true["recording_id"])
    false_groups = recording_groups(scored.false["recording_id"])
    for kind in SCORED_KINDS:
        true, false = scored.true["kind"] == kind, scored.false["kind"] == kind
        for level in [*sorted(groups[true].unique()), ALL]:
            here = true & groups.isin([level] if level != ALL else groups)
            wrong = false & false_groups.isin([level] if level != ALL else groups)
            if here.any():
                yield {"kind": kind, "level": level, **_row(scored.true[here], int(wrong.sum()))}


def _row(contacts: pd.DataFrame, false: int) -> dict[str, Any]:
    seen, hidden = contacts[contacts["seen"]], contacts[~contacts["seen"]]
    right = int(seen["found"].sum())
    return {
        "contacts": len(seen),
        "precision": _share(right, right + false),
        "recall": _share(right, len(seen)),
        "time error rms (ms)": 1e3 * np.sqrt((seen["error"] ** 2).mean()),
        "hidden": len(hidden),
        "hidden recall": _share(int(hidden["found"].sum()), len(hidden)),
    }


def _share(part: int, whole: int) -> float:
    return part / whole if whole else np.nan


def _metrics(table: pd.DataFrame) -> dict[str, Any]:
    metrics: dict[str, Any] = {}
    for row in table.to_dict("records"):
        numbers = {
            "precision": row["precision"],
            "recall": row["recall"],
            "time_error_rms_ms": row["time error rms (ms)"],
            "contacts": row["contacts"],
        }
        known = {name: round(value, 4) for name, value in numbers.items() if np.isfinite(value)}
        metrics.setdefault(row["kind"], {})[row["level"]] = known
    return metrics


if __name__ == "__main__":
    run_stage(score_segmentation)
