"""A repository with a small sweep, and a training that takes no time."""

import math
import shutil
from pathlib import Path

from ruamel.yaml import YAML

from rallygap.pipeline.sweeps.settings import Sweep
from rallygap.pipeline.sweeps.study import open_study, run_trials

ROOT = Path(__file__).parents[3]
RATE = "train_predictor.training.learning_rate"
HEADS = "train_predictor.networks.transformer.heads"
SETTINGS = {
    "trains": "predictor",
    "network": "transformer",
    "trials": 8,
    "in_trials": {"train_predictor.training.epochs": 3},
    "space": {RATE: {"low": 0.0001, "high": 0.1, "log": True}, HEADS: [2, 4, 8]},
    "pruning": {"first_trials": 3, "first_steps": 0},
}


def small_sweep(root, **changes):
    """Write what a sweep reads of a repository and load it; a setting of None is left out."""
    root.mkdir(exist_ok=True)
    if not (root / "params.yaml").exists():
        shutil.copy(ROOT / "params.yaml", root)
    stages = {
        stage: {"cmd": stage, "deps": ["data.txt"], "params": ["seed", stage], "outs": []}
        for stage in ("train_predictor", "train_policy")
    }
    write_yaml(root / "dvc.yaml", {"stages": stages})
    (root / "data.txt").write_text("shots")
    (root / "artifacts" / "segment").mkdir(parents=True, exist_ok=True)
    settings = {key: value for key, value in {**SETTINGS, **changes}.items() if value is not None}
    write_yaml(root / "experiments" / "profiles" / "sweeps" / "tiny.yaml", settings)
    return Sweep(root, "tiny")


def write_yaml(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    YAML(typ="safe").dump(content, path)


def valley(params, folder, report):
    """Return a score that is least at a learning rate of 0.01 after every epoch."""
    depth = (math.log10(params.train_predictor.training.learning_rate) + 2) ** 2
    for epoch in (1, 2, 3):
        report(epoch, depth + 1 / epoch)
    return depth + 1 / 3


def run(sweep, wanted, train=valley, url=None):
    """Run trials in this process; return the study."""
    study = open_study(sweep, url)
    run_trials(study, sweep, train, wanted)
    return study
