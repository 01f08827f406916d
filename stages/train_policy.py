"""Train the policies, each in its own simulator with exact forecasts."""

from collections.abc import Iterator

import pandas as pd

from models.policy.random_streams import training_seed
from pipeline.io.artifacts import write_table
from pipeline.io.simulators import load_simulator
from pipeline.policies.report import report_training
from pipeline.policies.storage import TrainedPolicy, save_policy
from pipeline.policies.training import (
    TEST_TRIALS,
    TrainingJob,
    play_test_shots,
    train_policies,
)
from pipeline.runtime.stage_run import StageRun, run_stage

RECORDED = 32  # test shots of the first policy, one of which is shown


def train_policy(run: StageRun) -> None:
    """Train the policies of all groups, and let each play test shots."""
    jobs = [TrainingJob(one, run.scratch(one.name)) for one in _descriptions(run)]
    results = train_policies(jobs)
    tests = play_test_shots(results, run.params.train_policy.trials, RECORDED)
    for one in results:
        save_policy(run.artifact(one.description.name), one.policy, one.description)
        run.timings[one.description.name] = {"training_cpu_s": round(one.seconds, 1)}
    tables = [test.table for test in tests]
    write_table(run.artifact(TEST_TRIALS), pd.concat(tables, ignore_index=True))
    report_training(run, results, tests)


def _descriptions(run: StageRun) -> Iterator[TrainedPolicy]:
    """Yield the policies to train; a repeat has the same seed in all simulators and horizons."""
    for name, group in run.params.train_policy.groups.items():
        for simulator in group.simulators:
            for horizons in group.horizons_ms:
                for repeat in range(group.repeats):
                    yield TrainedPolicy(
                        group=name,
                        simulator=simulator,
                        effects=load_simulator(simulator).to_dict(),
                        horizons=horizons,
                        observation=group.observation,
                        goals=group.goals,
                        learning=group.learning,
                        seed=training_seed(run.seed, repeat),
                        repeat=repeat,
                    )


if __name__ == "__main__":
    run_stage(train_policy)
