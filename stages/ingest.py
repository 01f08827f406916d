"""Read the recordings of every source into tables."""

from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.sources.gather import gather
from rallygap.pipeline.sources.report import launch_items, source_items, source_metrics


def ingest(run: StageRun) -> None:
    """Read, check and write the rows of all sources, and report on them."""
    artifacts = run.artifact(".")
    gathered = gather(run.params.ingest, run.seed, artifacts)
    manifest = gathered.manifest
    write_json(run.artifact("manifest.json"), manifest.model_dump(mode="json"))
    write_json(run.artifact("truth.json"), gathered.truth)
    for name, record in manifest.sources.items():
        simulated = run.artifact("recordings.parquet")
        run.log_input(name, gathered.folders.get(name, simulated), record.rows_kept)
    run.write_metrics({name: source_metrics(record) for name, record in manifest.sources.items()})
    run.add(*source_items(manifest, artifacts), *launch_items(artifacts))


if __name__ == "__main__":
    run_stage(ingest)
