"""Cut recordings into episodes: contacts, gaps, ends of rallies, velocities; split them."""

from rallygap.pipeline.io.source_manifest import read_manifest
from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.segmentation.cut_recordings import count_samples, draw_recordings
from rallygap.pipeline.segmentation.cut_report import segmentation_metrics, splits_table
from rallygap.pipeline.segmentation.episode_tables import write_episodes
from rallygap.pipeline.segmentation.figures.cuts import cuts_figure


def segment(run: StageRun) -> None:
    """Cut every recording, assign the recordings to splits, and report on each source."""
    settings = run.params.segment
    manifest = read_manifest(run.input("ingest", "manifest.json"))
    recordings = run.input("ingest", "recordings.parquet")
    counts = count_samples(recordings)
    run.log_input("recordings", recordings, int(counts.sum()))
    drawn = draw_recordings(counts, run.seed)

    ids = [recording_id for chosen in drawn.values() for recording_id in chosen]
    cut, episodes, shortages = write_episodes(run.root / "artifacts", settings, run.seed, ids)
    for shortage in shortages:
        warn(shortage)

    run.write_metrics(
        {
            source: segmentation_metrics(manifest, source, cut, episodes, settings)
            for source in drawn
        }
    )
    samples, contacts = cut.segmented.samples, cut.segmented.contacts
    for source, chosen in drawn.items():
        run.add(cuts_figure(source, cut.measured, samples, contacts, chosen))
    run.add(splits_table(episodes))


if __name__ == "__main__":
    run_stage(segment)
