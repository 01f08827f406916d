"""A repository with a committed run and an experiment to compare it with."""

import pytest
import yaml

from experiments.clone import cloned, commit, run
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.profiles import merged

TARGET, CHANGED = "train_predictor", "segment.outlier_cost"


def small_clone(folder):
    """Make a repository with the smallest parameters."""
    cloned(folder)
    params = read_yaml(folder / "params.yaml")
    params = merged(params, read_yaml(folder / "experiments" / "profiles" / "smoke.yaml"))
    (folder / "params.yaml").write_text(yaml.safe_dump(params, sort_keys=False))
    commit(folder, "small")
    return folder


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
