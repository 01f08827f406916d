"""Training and comparison of policies in sweeps, as in the stage train_policy."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.params import Params
from rallygap.pipeline.policies.storage import TrainedPolicy, described_policy
from rallygap.pipeline.policies.training import (
    RECORD,
    TrainingJob,
    learn,
    play_test_shots,
    train_policies,
)
from rallygap.pipeline.sweeps.comparison import SEEDS, comparison, repeat_seed
from rallygap.pipeline.sweeps.settings import PolicySweep, Report
from rallygap.pipeline.tracking.live import live_run

MEASURES = {"returned": "return rate", "hit": "hit rate"}


def score_policy(sweep: PolicySweep, params: Params, folder: Path, report: Report) -> float:
    """Train a policy; return the return rate on validation shots after the last iteration."""
    job = TrainingJob(described(sweep, params), folder)
    rate = 0.0
    for number in range(job.description.learning.iterations):
        learn(job, number, live_run(job.description.name))
        rate = read_json(job.iteration(number) / RECORD)["return_rate"]
        report(number + 1, rate)
    return rate


def described(sweep: PolicySweep, params: Params, repeat: int = 0) -> TrainedPolicy:
    """Return the description of a policy to train; ``repeat`` selects its seed."""
    seed = repeat_seed(params.seed, repeat)
    settings, horizons = params.train_policy, sweep.horizons_ms
    return described_policy(settings, sweep.group, sweep.simulator, horizons, seed, repeat)


def compare_policies(sweep: PolicySweep, settings: Sequence[Params], folder: Path) -> pd.DataFrame:
    """Train the policy with two parameter sets and every seed; compare it on unseen shots.

    Policies of one seed play the same shots. Checkpoints go into the folder.
    """
    jobs = [
        TrainingJob(described(sweep, params, repeat), folder / f"{number}-{repeat}")
        for number, params in enumerate(settings)
        for repeat in range(1, SEEDS + 1)
    ]
    shots = settings[0].train_policy.trials
    played = play_test_shots(train_policies(jobs), shots)
    rates = np.stack([test.table[list(MEASURES)].to_numpy(dtype=np.float64) for test in played])
    groups = np.arange(SEEDS * shots).reshape(SEEDS, shots)
    return comparison(list(MEASURES.values()), False, rates, groups, settings[0].seed)
