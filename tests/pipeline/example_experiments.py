"""A repository with a committed run and an experiment to compare it with."""

import pytest

from tests.clone import cloned, commit, rallygap, run

TARGET, CHANGED = "score_segmentation", "segment.outlier_cost"


@pytest.fixture(scope="session")
def experiments(tmp_path_factory):
    """A clone after a small run up to the target, committed, and the experiment `strict`."""
    folder = cloned(tmp_path_factory.mktemp("comparing") / "rallygap")
    flags = rallygap(folder, "profile", "smoke").split()
    run(folder, "dvc", "exp", "run", *flags, TARGET)
    commit(folder, "run")
    command = ["dvc", "exp", "run", "--temp", "--name", "strict", "-S"]
    changed = f"../params.yaml:{CHANGED}=4.0"  # DVC knows params.yaml only where it is
    run(folder, *command, changed, f"../dvc.yaml:{TARGET}", below="docs")
    return folder
