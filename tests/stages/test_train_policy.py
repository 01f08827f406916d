"""Training as a stage: policies of every group, the same ones every time, or one error."""

from types import SimpleNamespace

import pytest

from rallygap.models.policy.random_streams import evaluation_stream
from rallygap.models.policy.scores import scores
from rallygap.models.policy.trial import play
from rallygap.pipeline.io.artifacts import read_json, read_table
from rallygap.pipeline.params import PolicyGroupSettings, TrainPolicySettings
from rallygap.pipeline.policies import training as policy_training
from rallygap.pipeline.policies.storage import load_policy
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.train_policy import train_policy
from tests.models.policy.schooling import BRIEF, GOALS
from tests.stages.outputs import table

TRIALS = 12
GROUP = PolicyGroupSettings(
    simulators=["imperfect_c", "imperfect_a"],
    horizons_ms=[(115, 120, 125)],
    repeats=2,
    observation="intercept",
    goals=GOALS,
    learning=BRIEF.model_copy(update={"iterations": 1}),
)
STYLED = {
    "simulators": ["imperfect_c"],
    "horizons_ms": [(170, 175, 180)],
    "repeats": 1,
    "observation": "strict",
    "goals": GOALS.model_copy(update={"speed": (4.0, 7.0)}),
    "learning": BRIEF.model_copy(update={"iterations": 2}),
}
GROUPS = {"plain": GROUP, "styled": GROUP.model_copy(update=STYLED)}
NAMES = [
    *[f"plain-{simulator}-115ms-{k}" for simulator in GROUP.simulators for k in range(2)],
    "styled-imperfect_c-170ms-0",
]


def prepared(root, groups=GROUPS):
    settings = TrainPolicySettings(groups=groups, trials=TRIALS)
    return StageRun("train_policy", root, SimpleNamespace(train_policy=settings, seed=5), "f" * 64)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A run of two groups; not to be changed."""
    run = prepared(tmp_path_factory.mktemp("whole"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LOKY_MAX_CPU_COUNT", "1")  # other processes would take seconds to start
        patch.setattr(policy_training, "VALIDATION_SHOTS", 6)
        train_policy(run)
    return run


def policies(run):
    return {name: load_policy(run.artifact(name)) for name in NAMES}


def test_there_is_a_policy_for_each_simulator_horizons_and_repeat(whole):
    left = {path.name for path in whole.artifact(".").iterdir()}
    assert left == {*NAMES, policy_training.TEST_TRIALS, policy_training.RETURN, "report"}
    for name, (_, described) in policies(whole).items():
        group = GROUPS[described.group]
        assert (described.name, described.horizons) == (name, group.horizons_ms[0])
        assert (described.observation, described.goals) == (group.observation, group.goals)
        assert described.learning == group.learning
    seeds = {name: described.seed for name, (_, described) in policies(whole).items()}
    assert seeds["plain-imperfect_c-115ms-0"] != seeds["plain-imperfect_c-115ms-1"]
    for repeat in "01":
        assert len({seed for name, seed in seeds.items() if name.endswith(repeat)}) == 1
    assert set(whole.timings) == set(NAMES)


def test_the_report_scores_each_policy_on_unseen_balls_of_its_own_simulator(whole):
    rows = table(whole, "policies").to_dict("records")
    unseen = read_table(whole.artifact(policy_training.TEST_TRIALS))
    for (policy, described), row in zip(policies(whole).values(), rows, strict=True):
        task = described.task
        balls, goals = task.draw(TRIALS, evaluation_stream(described.seed))
        expected = scores(play(policy, task.simulator, balls, goals, task.observation).table)
        found = {name: row[name] for name in expected}
        assert found == pytest.approx(expected, rel=1e-5, nan_ok=True)
        own = (unseen[list(described.labels)] == described.labels.values()).all(axis=1)
        assert unseen.loc[own, "returned"].mean() == expected["return_rate"]
        assert (row["simulator"], row["repeat"]) == (described.simulator, described.repeat)
        assert row["control_steps"] == described.learning.iterations * BRIEF.steps_per_iteration
    metrics = read_json(whole.report("metrics.json"))
    found = {name: one["return_rate"] for name, one in metrics.items()}
    rates = table(whole, "policies").groupby("group")["return_rate"].mean()
    assert found == pytest.approx(rates.to_dict(), rel=1e-5)
