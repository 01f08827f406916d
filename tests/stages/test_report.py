"""The stage report needs all other stages."""

from pathlib import Path

import pytest

from rallygap.pipeline.params import load_params
from rallygap.pipeline.report.stages import PIPELINE, write_report
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun

REPOSITORY = Path(__file__).parents[2]


@pytest.mark.parametrize("stage", PIPELINE)
def test_a_stage_that_has_not_run_is_one_error(tmp_path, stage):
    run = StageRun("report", tmp_path, load_params(REPOSITORY / "params.yaml"))
    with pytest.raises(InputError, match="run"):
        write_report(run, stage, PIPELINE[stage])
    assert list(tmp_path.rglob("*.*")) == []
