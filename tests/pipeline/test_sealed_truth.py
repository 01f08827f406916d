"""The sealed truth: only the stages that may know it depend on it."""

from pathlib import Path

from rallygap.pipeline.params import read_yaml

ROOT = Path(__file__).parents[2]
STAGES = read_yaml(ROOT / "dvc.yaml")["stages"]

SEALED = {"artifacts/ingest/truth.json", "artifacts/ingest/true_contacts.parquet"}
# What knows the physics by name (the oracle), scores, or continues a ball after a stroke.
MAY_KNOW = {"evaluate_predictor", "score_segmentation", "sim2real", "retrain_policy"}


def test_only_the_stages_that_may_know_the_truth_depend_on_it():
    assert set(filter(lambda out: isinstance(out, str), STAGES["ingest"]["outs"])) >= SEALED
    knowing = {name for name, stage in STAGES.items() if SEALED & set(stage["deps"])}
    assert knowing == MAY_KNOW
    folders = {str(parent) for sealed in SEALED for parent in Path(sealed).parents}
    for stage in STAGES.values():
        assert not folders & {dependency.rstrip("/") for dependency in stage["deps"]}
