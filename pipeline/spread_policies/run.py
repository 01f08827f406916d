"""The experiment ``make spread-policies``: 15 minutes on two cores, after ``make reproduce``.

Three kinds of policies learn in the same simulator, with the same seeds: from exact forecasts; from
forecasts that a filter makes of noisy measurements; and from these with their standard deviations.
All start when a filter has its first window, and play the shots of sim2real with the same
predictors. A killed run resumes.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import pandas as pd

from rallygap.models.policy.random_streams import training_seed
from rallygap.models.policy.settings import ForecastKind, ObservationKind
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import ProbabilisticPredictor
from rallygap.pipeline.evaluation.predictors import read_learned
from rallygap.pipeline.experiments.experiment import running
from rallygap.pipeline.io.amended_simulators import amended_by
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Params, load_params
from rallygap.pipeline.policies.storage import TrainedPolicy
from rallygap.pipeline.policies.training import TrainingJob, train_policies
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import repository_root
from rallygap.pipeline.spread_policies.figure import spread_policies_figure
from rallygap.pipeline.transfer.rates import differences, rates
from rallygap.pipeline.transfer.replay_sets import ReplaySet, read_replay_sets
from rallygap.pipeline.transfer.replay_trials import (
    EveryStepWithSpreads,
    Policies,
    informed_predictors,
    replay_trials,
    source_of,
)
from rallygap.pipeline.transfer.transfer_table import PHYSICS
from rallygap.pipeline.transfer.trials import joined, run_trials

REPEATS, HORIZONS = 3, (115, 120, 125)
# What policies observe, and which forecasts they learn from.
KINDS: dict[str, tuple[ObservationKind, ForecastKind]] = {
    "exact": ("intercept", "exact_after_window"),
    "filtered": ("intercept", "filtered"),
    "filtered_with_spread": ("spread", "filtered"),
}
BASELINE = "filtered"  # of the paired differences
NAME = "spread_policies"  # of reports
INPUTS = (
    "artifacts/ingest",
    "artifacts/segment",
    "artifacts/train_predictor",
    "artifacts/close_gap",
)


def spread_policies(root: Path) -> None:
    """Write return rates, paired differences and their figure to ``reports``.

    Raises:
        InputError: the stages before have not run, or the experiment cannot start.
    """
    with running(root, "spread_policies.run", INPUTS) as run:
        params = load_params(root / "params.yaml")
        sets = read_replay_sets(root / "artifacts", params.sim2real, params.seed)
        predictors = {one.name: _predictors(root, params, one) for one in sets}
        jobs = [TrainingJob(one, run.scratch / one.name) for one in _descriptions(params)]
        trained = [(one.policy, one.description) for one in train_policies(jobs)]
        played = _played(sets, predictors, trained, params.seed)
        tables = _tables(played)
        figures = {NAME: spread_policies_figure(tables[NAME])}
        sample = {"seed": params.seed, "policies": len(trained)}
        run.publish("", tables, figures, NAME, sample)


def _tables(played: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the tables by the names of their files."""
    setting, baseline = ["set", "predictor"], {"policy": BASELINE}
    return {
        NAME: rates(played, [*setting, "policy"]),
        f"{NAME}_differences": differences(played, setting, baseline),
    }


def _descriptions(params: Params) -> Iterator[TrainedPolicy]:
    """Yield the policies to train, with the goals and the learning of sim2real's."""
    simulator, group = params.sim2real.simulator, params.train_policy.groups[params.sim2real.group]
    for name, (observation, forecasts) in KINDS.items():
        for repeat in range(REPEATS):
            yield TrainedPolicy(
                group=name,
                simulator=simulator,
                effects=load_simulator(simulator).to_dict(),
                horizons=HORIZONS,
                observation=observation,
                goals=group.goals,
                learning=group.learning,
                seed=training_seed(params.seed, repeat),
                repeat=repeat,
                forecasts=forecasts,
                reward=params.train_policy.reward,
            )


Predictors = Mapping[str, ProbabilisticPredictor]  # by name


def _predictors(root: Path, params: Params, shots: ReplaySet) -> Predictors:
    """Return the predictors of sim2real for a set."""
    simulator = params.sim2real.simulator
    amended = amended_by(root / "artifacts" / "close_gap", source_of(shots), simulator)
    learned = read_learned(root / "artifacts" / "train_predictor", params.sim2real.learned)
    physics = PhysicsPredictor(load_simulator(simulator))
    return {PHYSICS: physics, **informed_predictors(shots, learned, amended)}


def _played(
    sets: list[ReplaySet], predictors: Mapping[str, Predictors], policies: Policies, seed: int
) -> pd.DataFrame:
    """Return one row a policy, shot and predictor; ``policy`` is the kind."""
    forecasters = {
        name: [EveryStepWithSpreads(*named) for named in some.items()]
        for name, some in predictors.items()
    }
    tables = []
    for kind in KINDS:
        own = [one for one in policies if one[1].group == kind]
        trials = [
            trial for one in sets for trial in replay_trials(one, forecasters[one.name], own, seed)
        ]
        tables.append(joined(run_trials(trials)).assign(policy=kind))
    return pd.concat(tables, ignore_index=True)


if __name__ == "__main__":
    try:
        spread_policies(repository_root())
    except InputError as error:
        refuse(error)
