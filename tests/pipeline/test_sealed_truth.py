"""The sealed truth: only the stages that may know it depend on it."""

from pathlib import Path

import pytest

from rallygap.pipeline.params import read_yaml

ROOT = Path(__file__).parents[2]
STAGES = read_yaml(ROOT / "dvc.yaml")["stages"]

SEALED = {"artifacts/ingest/truth.json", "artifacts/ingest/true_contacts.parquet"}
# What knows the physics by name (the oracle), scores, or continues a ball after a stroke.
MAY_KNOW = {
    "evaluate_predictor",
    "score_segmentation",
    "sim2real",
    "retrain_policy",
}


def test_the_truth_is_an_output_of_its_own():
    outputs = [out for out in STAGES["ingest"]["outs"] if isinstance(out, str)]

    assert set(outputs) >= SEALED


@pytest.mark.parametrize("stage", [stage for stage in STAGES if stage not in MAY_KNOW])
def test_a_stage_that_must_find_things_out_does_not_know_them(stage):
    assert not SEALED & set(STAGES[stage]["deps"])


@pytest.mark.parametrize("stage", STAGES)
def test_no_stage_depends_on_the_folder_around_the_truth(stage):
    folders = {str(parent) for sealed in SEALED for parent in Path(sealed).parents}

    assert not folders & {dependency.rstrip("/") for dependency in STAGES[stage]["deps"]}
