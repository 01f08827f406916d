"""A run on balls whose physics is known, and its windows."""

import pytest

from rallygap.pipeline.benchmark.windows import run_sets
from tests.pipeline.measured_shots import params, write_inputs


@pytest.fixture(scope="session")
def root(tmp_path_factory):
    """What the stages before evaluate_predictor left; not to be changed."""
    made = tmp_path_factory.mktemp("run")
    write_inputs(made)
    return made


@pytest.fixture(scope="session")
def sets(root):
    """Its test windows."""
    return run_sets(root, params())
