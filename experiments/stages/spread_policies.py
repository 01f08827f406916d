"""Policies that observe how sure forecasts are; 15 minutes on two cores.

Three kinds of policies learn in the same simulator, with the same seeds: from exact forecasts; from
forecasts that a filter makes of noisy measurements; and from these with their standard deviations.
All start when a filter has its first window, and play the shots of sim2real with the same
predictors.
"""

from collections.abc import Iterator, Mapping

import pandas as pd

from rallygap.models.policy.random_streams import training_seed
from rallygap.models.policy.settings import ForecastKind, ObservationKind
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import ProbabilisticPredictor
from rallygap.pipeline.evaluation.predictors import read_learned
from rallygap.pipeline.io.amended_simulators import amended_by
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Params
from rallygap.pipeline.policies.storage import TrainedPolicy
from rallygap.pipeline.policies.training import TrainingJob, train_policies
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.transfer.rates import differences, rates
from rallygap.pipeline.transfer.replay_sets import ReplaySet, read_replay_sets
from rallygap.pipeline.transfer.replay_trials import (
    Forecaster,
    Policies,
    informed_predictors,
    replay_trials,
    source_of,
)
from rallygap.pipeline.transfer.returns import PHYSICS
from rallygap.pipeline.transfer.trials import joined, run_trials

REPEATS, HORIZONS = 3, (115, 120, 125)
# What policies observe, and which forecasts they learn from.
KINDS: dict[str, tuple[ObservationKind, ForecastKind]] = {
    "exact": ("intercept", "exact_after_window"),
    "filtered": ("intercept", "filtered"),
    "filtered_with_spread": ("spread", "filtered"),
}
BASELINE = "filtered"  # of the paired differences


def spread_policies(run: StageRun) -> None:
    """Write return rates and paired differences."""
    sets = read_replay_sets(run.root / "artifacts", run.params.sim2real, run.seed)
    predictors = {shots.name: _predictors(run, shots) for shots in sets}
    jobs = [
        TrainingJob(description, run.scratch(description.name))
        for description in _descriptions(run.params)
    ]
    trained = [(result.policy, result.description) for result in train_policies(jobs)]
    played = _played(sets, predictors, trained, run.seed)
    setting = ["set", "predictor"]
    run.publish(
        {
            "rates": rates(played, [*setting, "policy"]),
            "differences": differences(played, setting, {"policy": BASELINE}),
        }
    )


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


def _predictors(run: StageRun, shots: ReplaySet) -> Predictors:
    """Return the predictors of sim2real for a set."""
    settings = run.params.sim2real
    simulator = settings.simulator
    amended = amended_by(run.input("close_gap", ""), source_of(shots), simulator)
    learned = read_learned(run.input("train_predictor", ""), settings.learned)
    physics = PhysicsPredictor(load_simulator(simulator))
    return {PHYSICS: physics, **informed_predictors(shots, learned, amended)}


def _played(
    sets: list[ReplaySet], predictors: Mapping[str, Predictors], policies: Policies, seed: int
) -> pd.DataFrame:
    """Return one row a policy, shot and predictor; ``policy`` is the kind."""
    forecasters = {
        name: [Forecaster(*named, spreads=True) for named in members.items()]
        for name, members in predictors.items()
    }
    tables = []
    for kind in KINDS:
        own = [pair for pair in policies if pair[1].group == kind]
        trials = [
            trial.run
            for shots in sets
            for trial in replay_trials(shots, forecasters[shots.name], own, seed)
        ]
        tables.append(joined(run_trials(trials)).assign(policy=kind))
    return pd.concat(tables, ignore_index=True)


if __name__ == "__main__":
    run_stage(spread_policies)
