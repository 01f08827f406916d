"""What a sweep of policies trains: one policy, in one simulator, watched after every leg."""

from pathlib import Path

from pipeline.io.artifacts import read_json
from pipeline.io.simulators import load_simulator
from pipeline.params import Params
from pipeline.policies.storage import TrainedPolicy
from pipeline.policies.training import RECORD, Pupil, learn
from pipeline.sweeps.paired_comparison import repeat_seed
from pipeline.sweeps.settings import PolicySweep
from pipeline.sweeps.trial_types import Watch


class PolicyTrials:
    """Trains a policy and scores it on balls that it does not learn from.

    Args:
        sweep: which group's policy, in which simulator, told how far ahead.
    """

    def __init__(self, sweep: PolicySweep) -> None:
        self.sweep = sweep

    def score(self, params: Params, folder: Path, watch: Watch) -> float:
        """Return the share of watched balls that come back after the last leg."""
        pupil = Pupil(described(self.sweep, params), folder)
        rate = 0.0
        for leg in range(pupil.description.learning.legs):
            learn(pupil, leg)
            rate = read_json(pupil.leg(leg) / RECORD)["return_rate"]
            watch(leg + 1, rate)
        return rate


def described(sweep: PolicySweep, params: Params, repeat: int = 0) -> TrainedPolicy:
    """Return what is to be trained; ``repeat`` tells seeds apart, as in the stage."""
    group = params.train_policy.groups[sweep.group]
    return TrainedPolicy(
        group=sweep.group,
        simulator=sweep.simulator,
        effects=load_simulator(sweep.simulator).to_dict(),
        horizons=sweep.horizons_ms,
        observation=group.observation,
        goals=group.goals,
        learning=group.learning,
        seed=repeat_seed(params.seed, repeat),
        repeat=repeat,
    )
