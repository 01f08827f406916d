"""The stage: policies of all kinds play the same shots."""

import pandas as pd
import pytest

import experiments.stages.spread_policies as run
from rallygap.pipeline.policies import training
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.models.policy.schooling import BRIEF, GOALS
from tests.pipeline.amendments import write_amended
from tests.pipeline.killed_runs import kill_at
from tests.pipeline.measured_shots import params
from tests.pipeline.replayed import SETTINGS, replayed, write_replays


@pytest.fixture
def stage(tmp_path, monkeypatch):
    """A run with two shots to replay, and with short trainings."""
    shots = [replayed("arena/pro", number) for number in (4, 5)]
    artifacts = write_replays(tmp_path, shots, sources=("arena",))
    write_amended(artifacts / "close_gap", "arena", "imperfect_c", {"drag": {"cd": 0.54}})
    plain = params(sim2real=SETTINGS)
    group = next(iter(plain.train_policy.groups.values()))
    small = group.model_copy(update={"goals": GOALS, "learning": BRIEF})
    policies = plain.train_policy.model_copy(update={"groups": {SETTINGS.group: small}})
    used = plain.model_copy(update={"train_policy": policies})
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "1")
    monkeypatch.setattr(training, "VALIDATION_SHOTS", 2)
    monkeypatch.setattr(run, "REPEATS", 1)
    return StageRun("spread_policies", tmp_path, used)


def test_a_killed_run_resumes_and_publishes_rates(stage, monkeypatch):
    learned, train = [], training._train

    def noted(job, iteration, *others):
        learned.append((job.description.group, iteration))
        train(job, iteration, *others)

    monkeypatch.setattr(training, "_train", noted)
    kill_at(run, "_played", run.spread_policies, stage)
    run.spread_policies(stage)
    assert len(learned) == len(set(learned)) == len(run.KINDS) * BRIEF.iterations
    rates = pd.read_csv(stage.report("rates.csv"))
    assert set(rates["policy"]) == set(run.KINDS)
    assert set(rates["predictor"]) == {"physics", "amended", "oracle", "tiny"}
    pairs = pd.read_csv(stage.report("differences.csv"))
    assert set(pairs["policy"]) == {*run.KINDS} - {run.BASELINE}
