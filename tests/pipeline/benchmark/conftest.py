"""A finished run on balls whose physics is known, and its windows."""

import pytest

from pipeline.benchmark.windows import run_sets
from pipeline.run import StageRun
from stages.evaluate_predictor import evaluate_predictor
from tests.pipeline.measured_shots import params, write_inputs


@pytest.fixture(scope="session")
def root(tmp_path_factory):
    """What a run left; not to be changed."""
    made = tmp_path_factory.mktemp("run")
    write_inputs(made)
    evaluate_predictor(StageRun("evaluate_predictor", made, params()))
    return made


@pytest.fixture(scope="session")
def sets(root):
    """Its test windows."""
    return run_sets(root, params())
