"""A repository with small sweeps, and trials that take no time."""

import math
import os
import shutil
from contextlib import contextmanager
from pathlib import Path

from ruamel.yaml import YAML

from pipeline.sweeps.lost_trials import Signature
from pipeline.sweeps.plan import load_plan
from pipeline.sweeps.study import create_study, load_study
from pipeline.sweeps.trial_tracking import TrialRecord
from pipeline.sweeps.worker import Worker

ROOT = Path(__file__).parents[3]
RATE = "train_predictor.training.learning_rate"
HEADS = "train_predictor.networks.transformer.heads"
TINY = {
    "trains": "predictor",
    "network": "transformer",
    "trials": 8,
    "in_trials": {"train_predictor.training.epochs": 3},
    "space": {RATE: {"low": 0.0001, "high": 0.1, "log": True}, HEADS: {"choices": [2, 4, 8]}},
    "pruning": {"first_trials": 3, "first_steps": 0},
}


def write_repository(root, name="tiny", **changes):
    """Write what a sweep reads of a repository; a setting that changes to None is left out."""
    shutil.copy(ROOT / "params.yaml", root)
    stages = {
        stage: {"cmd": stage, "deps": ["data.txt"], "params": ["seed", stage], "outs": []}
        for stage in ("train_predictor", "train_policy")
    }
    write_yaml(root / "dvc.yaml", {"stages": stages})
    (root / "data.txt").write_text("balls")
    settings = {key: value for key, value in {**TINY, **changes}.items() if value is not None}
    write_yaml(root / "profiles" / "sweeps" / f"{name}.yaml", settings)
    return root


def write_yaml(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    YAML(typ="safe").dump(content, path)


def plan(root, name="tiny", **changes):
    return load_plan(write_repository(root, name, **changes), name)


class Valley:
    """Trials whose score is least at a learning rate of a hundredth, as early as after an epoch."""

    def score(self, params, folder, watch):
        depth = (math.log10(params.train_predictor.training.learning_rate) + 2) ** 2
        for epoch in (1, 2, 3):
            watch(epoch, depth + 1 / epoch)
        return depth + 1 / 3


def done(plan, wanted, trials=None, url=None):
    """Let one worker do trials, in this process; return the study."""
    study = create_study(plan, url)
    own = load_study(plan, study.study_name, url)
    with Signature(plan.scratch / "workers") as signature:
        worker = Worker(plan, trials or Valley(), signature, lambda line: None, os.getppid())
        worker.work(own, wanted, lambda: signature.retry_lost(own))
    return study


@contextmanager
def unrecorded(*_):
    """In place of ``recorded_trial``, which would start a process."""
    yield TrialRecord()
