"""The run: policies of all kinds play the same shots, with the record of the sample."""

import pandas as pd
import pytest
from rallygap.pipeline.experiments.spread_policies import run

from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.policies import training
from tests.models.policy.schooling import BRIEF, GOALS
from tests.pipeline.amendments import write_amended
from tests.pipeline.killed_runs import kill_at
from tests.pipeline.measured_shots import params
from tests.pipeline.replayed import SETTINGS, replayed, write_replays


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A repository with two shots to replay, and with short trainings."""
    shots = [replayed("arena/pro", number) for number in (4, 5)]
    artifacts = write_replays(tmp_path, shots, sources=("arena",))
    write_amended(artifacts / "close_gap", "arena", "imperfect_c", {"drag": {"cd": 0.54}})
    (tmp_path / "params.yaml").write_text("seed: 1")
    plain = params(sim2real=SETTINGS)
    group = next(iter(plain.train_policy.groups.values()))
    small = group.model_copy(update={"goals": GOALS, "learning": BRIEF})
    policies = plain.train_policy.model_copy(update={"groups": {SETTINGS.group: small}})
    used = plain.model_copy(update={"train_policy": policies})
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "1")
    monkeypatch.setattr(training, "VALIDATION_SHOTS", 2)
    monkeypatch.setattr(run, "load_params", lambda path: used)
    monkeypatch.setattr(run, "REPEATS", 1)
    return tmp_path


def test_a_killed_run_resumes_and_publishes_rates(root, monkeypatch):
    learned, train = [], training._train

    def noted(job, iteration, before):
        learned.append((job.description.group, iteration))
        train(job, iteration, before)

    monkeypatch.setattr(training, "_train", noted)
    kill_at(run, "_played", run.spread_policies, root)
    run.spread_policies(root)
    assert len(learned) == len(set(learned)) == len(run.KINDS) * BRIEF.iterations
    rates = pd.read_csv(root / "reports/spread_policies.csv")
    assert set(rates["policy"]) == set(run.KINDS)
    assert set(rates["predictor"]) == {"physics", "amended", "oracle", "tiny"}
    pairs = pd.read_csv(root / "reports/spread_policies_differences.csv")
    assert set(pairs["policy"]) == {*run.KINDS} - {run.BASELINE}
    record = read_json(root / "reports/spread_policies.json")
    assert record["policies"] == 3
    assert (root / "reports/spread_policies.png").exists()
    assert not list((root / "scratch").rglob("record.json"))
