"""Train the policies, each in its own simulator with exact forecasts."""

from typing import Any

import numpy as np
import pandas as pd

from rallygap.models.policy.trial import TrialResult
from rallygap.pipeline.io.artifacts import replacing, write_table
from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.policies.storage import described_policies, save_policy
from rallygap.pipeline.policies.training import (
    RETURN,
    TEST_TRIALS,
    TrainingJob,
    play_test_shots,
    policies_table,
    train_policies,
    trained_models,
)
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

RECORDED = 32  # test shots of the first policy, one of which is shown


def train_policy(run: StageRun) -> None:
    """Train the policies of all groups, and let each play test shots."""
    described = list(described_policies(run.params.train_policy, run.seed))
    jobs = [TrainingJob(description, run.scratch(description.name)) for description in described]
    results = train_policies(jobs)
    tests = play_test_shots(results, run.params.train_policy.trials, RECORDED)
    for result in results:
        name = result.description.name
        save_policy(run.artifact(name), result.policy, result.description)
        run.timings[name] = {"training_cpu_s": round(result.seconds, 1)}
    run.models = trained_models(results, tests, run.artifact("."))
    tables = [test.table for test in tests]
    write_table(run.artifact(TEST_TRIALS), pd.concat(tables, ignore_index=True))
    _write_motion(run, described[0].name, tests[0])
    curves = [result.curve.assign(**result.description.labels) for result in results]
    policies = policies_table(results, tests)
    run.keep(learning=pd.concat(curves), policies=policies)
    run.write_metrics(_metrics(policies))


def _write_motion(run: StageRun, name: str, test: TrialResult) -> None:
    """Write the first return among the recorded shots, or the first shot if there is none."""
    returned = test.table["returned"].to_numpy()[: len(test.motions)]
    shot = int(returned.argmax())
    motion = test.motions[shot]
    with replacing(run.artifact(RETURN)) as path:
        np.savez(path, policy=name, joints=motion.joints, ball=motion.ball, returned=returned[shot])


def _metrics(policies: pd.DataFrame) -> dict[str, Any]:
    """Return ``{group: {return_rate}}``, means over its policies."""
    means = policies.groupby("group", sort=False)["return_rate"].mean()
    return {str(group): {"return_rate": rounded(rate)} for group, rate in means.items()}


if __name__ == "__main__":
    run_stage(train_policy)
