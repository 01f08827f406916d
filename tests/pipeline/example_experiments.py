"""A repository with a committed run and an experiment to compare it with."""

import pytest
import yaml

from experiments.clone import cloned, commit, run
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.profiles import merged

TARGET, CHANGED = "train_predictor", "segment.outlier_cost"


@pytest.fixture(scope="session")
def experiments(tmp_path_factory):
    """A clone with small parameters, run up to the target as `base` and `strict`; `base` stays."""
    folder = cloned(tmp_path_factory.mktemp("comparing") / "rallygap")
    small = merged(
        read_yaml(folder / "params.yaml"), read_yaml(folder / "experiments/profiles/smoke.yaml")
    )
    (folder / "params.yaml").write_text(yaml.safe_dump(small, sort_keys=False))
    commit(folder, "small")
    run(folder, "dvc", "exp", "run", "--name", "base", "score_segmentation", TARGET)
    commit(folder, "run")
    command = ["dvc", "exp", "run", "--temp", "--name", "strict", "-S"]
    changed = f"../params.yaml:{CHANGED}=4.0"  # DVC knows params.yaml only where it is
    run(
        folder,
        *command,
        changed,
        "../dvc.yaml:score_segmentation",
        f"../dvc.yaml:{TARGET}",
        below="docs",
    )
    return folder
