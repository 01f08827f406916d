"""The stage report: it is what writes tables and figures, and depends on all other stages."""

from pathlib import Path

import pytest

from rallygap.pipeline.params import load_params, read_yaml
from rallygap.pipeline.report.stages import PIPELINE, write_report
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun

REPOSITORY = Path(__file__).parents[2]
STAGES = read_yaml(REPOSITORY / "dvc.yaml")["stages"]


def test_every_stage_is_reported_in_the_order_of_the_pipeline():
    assert set(PIPELINE) == set(STAGES) - {"report"}


@pytest.mark.parametrize("stage", PIPELINE)
def test_a_stage_that_has_not_run_is_one_error(tmp_path, stage):
    run = StageRun("report", tmp_path, load_params(REPOSITORY / "params.yaml"))
    with pytest.raises(InputError, match="run"):
        write_report(run, stage)
    assert list(tmp_path.rglob("*.*")) == []
