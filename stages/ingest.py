"""Read the recordings of every source into tables."""

import pandas as pd

from rallygap.pipeline.io.artifacts import read_table, write_json
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.sources.gather import gather
from rallygap.pipeline.sources.launches import measured_launches, simulated_launches


def ingest(run: StageRun) -> None:
    """Read, check and write the rows of all sources, and report on them."""
    artifacts = run.artifact(".")
    gathered = gather(run.params.ingest, run.seed, artifacts)
    manifest = gathered.manifest
    write_json(run.artifact("manifest.json"), manifest.model_dump(mode="json"))
    write_json(run.artifact("truth.json"), gathered.truth)
    for name, record in manifest.sources.items():
        folder = gathered.folders.get(name, run.artifact("recordings.parquet"))
        run.log_input(name, folder, record.rows_kept)
    read = manifest.sources.items()
    run.write_metrics({name: {"recordings": record.recordings} for name, record in read})
    simulated = simulated_launches(read_table(run.artifact("true_contacts.parquet")))
    measured = measured_launches(read_table(run.artifact("launches.parquet")))
    run.keep(launches=pd.concat([simulated, measured], ignore_index=True))


if __name__ == "__main__":
    run_stage(ingest)
