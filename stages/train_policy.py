"""Train the policies, each in its own simulator with exact forecasts."""

import pandas as pd

from rallygap.pipeline.io.artifacts import write_table
from rallygap.pipeline.policies.descriptions import described_policies
from rallygap.pipeline.policies.report import report_training
from rallygap.pipeline.policies.storage import save_policy
from rallygap.pipeline.policies.training import (
    TEST_TRIALS,
    TrainingJob,
    play_test_shots,
    train_policies,
    trained_models,
)
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

RECORDED = 32  # test shots of the first policy, one of which is shown


def train_policy(run: StageRun) -> None:
    """Train the policies of all groups, and let each play test shots."""
    described = described_policies(run.params.train_policy, run.seed)
    jobs = [TrainingJob(one, run.scratch(one.name)) for one in described]
    results = train_policies(jobs)
    tests = play_test_shots(results, run.params.train_policy.trials, RECORDED)
    for result in results:
        name = result.description.name
        save_policy(run.artifact(name), result.policy, result.description)
        run.timings[name] = {"training_cpu_s": round(result.seconds, 1)}
    run.models = trained_models(results, tests, run.artifact("."))
    tables = [test.table for test in tests]
    write_table(run.artifact(TEST_TRIALS), pd.concat(tables, ignore_index=True))
    report_training(run, results, tests)


if __name__ == "__main__":
    run_stage(train_policy)
