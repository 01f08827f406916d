"""Cut recordings into episodes: contacts, gaps, ends of rallies, velocities; split them."""

import pandas as pd

from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.segmentation.cut_recordings import (
    count_samples,
    draw_recordings,
    write_episodes,
)


def segment(run: StageRun) -> None:
    """Cut every recording, assign the recordings to splits, and report on each source."""
    settings = run.params.segment
    recordings = run.input("ingest", "recordings.parquet")
    counts = count_samples(recordings)
    run.log_input("recordings", recordings, int(counts.sum()))
    drawn = draw_recordings(counts, run.seed)

    ids = [recording_id for chosen in drawn.values() for recording_id in chosen]
    cut, episodes, shortages = write_episodes(run.root / "artifacts", settings, run.seed, ids)
    for shortage in shortages:
        warn(shortage)

    run.write_metrics({source: _metrics(episodes, source) for source in drawn})
    contacts = cut.segmented.contacts
    run.keep(
        drawn_recordings=cut.measured,
        drawn_samples=cut.segmented.samples,
        drawn_contacts=contacts[contacts["recording_id"].isin(ids)],
    )


def _metrics(episodes: pd.DataFrame, source: str) -> dict[str, float]:
    """Return the number of a source's episodes, and how well paths fit them."""
    residuals = episodes.loc[episodes["source"] == source, "residual"]
    fit = {"median_residual_mm": round(1e3 * residuals.median(), 3)} if len(residuals) else {}
    return {"episodes": len(residuals), **fit}


if __name__ == "__main__":
    run_stage(segment)
