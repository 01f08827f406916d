"""A repository with a committed run and an experiment to compare it with."""

import pytest

from experiments.clone import commit, run, small_clone

TARGET, CHANGED = "train_predictor", "segment.outlier_cost"


@pytest.fixture(scope="session")
def experiments(tmp_path_factory):
    """A small clone, run up to the target as `base` and `strict`; `base` stays."""
    folder = small_clone(tmp_path_factory.mktemp("comparing") / "rallygap")
    run(folder, "dvc", "exp", "run", "--name", "base", "score_segmentation", TARGET)
    commit(folder, "run")
    command = ["dvc", "exp", "run", "--temp", "--name", "strict", "-S"]
    command += [f"../params.yaml:{CHANGED}=4.0"]  # DVC knows params.yaml only where it is
    targets = ["../dvc.yaml:score_segmentation", f"../dvc.yaml:{TARGET}"]
    run(folder, *command, *targets, below="docs")
    return folder
