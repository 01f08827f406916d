"""Policies as they are and as a sweep found them, on balls that none of them has seen."""

from pathlib import Path

import numpy as np

from pipeline.params import Params
from pipeline.policies.training import Pupil, train_policies, try_policies
from pipeline.sweeps.paired_comparison import SEEDS, Judged
from pipeline.sweeps.policy_trial import described
from pipeline.sweeps.settings import PolicySweep

MEASURES = {"returned": "return rate", "hit": "hit rate"}


def judged_policies(sweep: PolicySweep, both: list[Params], folder: Path) -> Judged:
    """Train the policy with both parameters and every seed; let all play unseen balls.

    Policies of one seed play the same balls.

    Args:
        sweep: which group's policy, in which simulator, told how far ahead.
        both: the parameters as they are, and those found.
        folder: for what the legs of a training leave.
    """
    pupils = [
        Pupil(described(sweep, params, repeat), folder / f"{name}-{repeat}")
        for name, params in zip(("params", "found"), both, strict=True)
        for repeat in range(1, SEEDS + 1)
    ]
    balls = both[0].train_policy.trials
    played = try_policies(train_policies(pupils), balls)
    rates = np.stack([table[list(MEASURES)].to_numpy(dtype=np.float64) for table in played])
    return Judged(
        list(MEASURES.values()),
        smaller_is_better=False,
        params=rates[:SEEDS],
        found=rates[SEEDS:],
        groups=np.arange(SEEDS * balls).reshape(SEEDS, balls),
    )
