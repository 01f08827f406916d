"""Score the contacts that segmentation detects against the truth of simulated recordings."""

from rallygap.pipeline.io.schemas import TRUE_CONTACTS, read_checked
from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.segmentation.contact_scores import (
    contact_metrics,
    contacts_table,
    score_test_recordings,
)


def score_segmentation(run: StageRun) -> None:
    """Compare contacts detected in test recordings with the true ones, by players' level."""
    settings = run.params.score_segmentation
    ingested = run.input("ingest", "recordings.parquet").parent
    segmented = run.input("segment", "episodes.parquet").parent
    truth = run.input("ingest", "true_contacts.parquet")
    true = read_checked(truth, TRUE_CONTACTS)
    run.log_input("true_contacts", truth, len(true))
    scored = score_test_recordings(ingested, segmented, true, settings)
    table = contacts_table(scored)
    if table.empty:
        warn("no simulated recording is in the test split: there are no contacts to score")
    run.write_metrics(contact_metrics(table))
    run.keep(contacts=table, observable=scored.true[scored.true["observable"]])


if __name__ == "__main__":
    run_stage(score_segmentation)
