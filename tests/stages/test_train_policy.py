"""Training as a stage: policies of every group, the same ones every time, or one error."""

from itertools import count
from types import SimpleNamespace

import pytest

from rallygap.models.policy import learning
from rallygap.models.policy.random_streams import evaluation_stream
from rallygap.models.policy.scores import scores
from rallygap.models.policy.trial import play
from rallygap.pipeline.io.artifacts import read_json, read_table
from rallygap.pipeline.params import PolicyGroupSettings, TrainPolicySettings
from rallygap.pipeline.policies import training as policy_training
from rallygap.pipeline.policies.storage import load_policy
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.train_policy import train_policy
from tests.models.policy.schooling import BRIEF, GOALS
from tests.stages.outputs import items

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


def in_one_process(patch):
    """Train in this process, where other processes would take seconds to start."""
    patch.setenv("LOKY_MAX_CPU_COUNT", "1")
    patch.setattr(policy_training, "VALIDATION_SHOTS", 6)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A run of two groups; not to be changed."""
    run = prepared(tmp_path_factory.mktemp("whole"))
    with pytest.MonkeyPatch.context() as patch:
        in_one_process(patch)
        train_policy(run)
    return run


def policies(run):
    return {name: load_policy(run.artifact(name)) for name in NAMES}


def test_there_is_a_policy_for_each_simulator_horizons_and_repeat(whole):
    left = {path.name for path in whole.artifact(".").iterdir()}
    assert left == {*NAMES, policy_training.TEST_TRIALS, policy_training.RETURN, "report"}
    for name, (_, described) in policies(whole).items():
        group = GROUPS[described.group]
        assert described.name == name
        assert described.horizons == group.horizons_ms[0]
        assert (described.observation, described.goals) == (group.observation, group.goals)
        assert described.learning == group.learning
    seeds = {name: described.seed for name, (_, described) in policies(whole).items()}

    assert seeds["plain-imperfect_c-115ms-0"] != seeds["plain-imperfect_c-115ms-1"]
    for repeat in "01":
        assert len({seed for name, seed in seeds.items() if name.endswith(repeat)}) == 1
    files = [
        "figures/learning.png",
        "figures/return.png",
        "figures/achieved_styled.png",
        "policies.csv",
    ]

    assert [item.file for item in items(whole)] == files
    assert set(whole.timings) == set(NAMES)


def test_the_report_scores_each_policy_on_unseen_balls_of_its_own_simulator(whole):
    table = whole.kept("train_policy", "policies").set_index("group", append=True)
    unseen = read_table(whole.artifact(policy_training.TEST_TRIALS))

    for (policy, described), (_, row) in zip(
        policies(whole).values(), table.iterrows(), strict=True
    ):
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
    rates = table.groupby("group")["return_rate"].mean()
    assert found == pytest.approx(rates.to_dict(), rel=1e-5)


def test_a_run_that_was_killed_is_taken_up_to_the_same_bytes(whole, tmp_path, monkeypatch):
    in_one_process(monkeypatch)
    styled = {"styled": GROUPS["styled"]}
    clock = SimpleNamespace(process_time=count().__next__)  # a second at every look
    monkeypatch.setattr(policy_training, "time", clock)
    with monkeypatch.context() as patch, pytest.raises(RuntimeError, match="killed"):
        patch.setattr(learning, "learn_iteration", killed_in_a_second_leg(learning.learn_iteration))
        train_policy(prepared(tmp_path, styled))
    again = prepared(tmp_path, styled)
    train_policy(again)
    assert again.timings == {NAMES[-1]: {"training_cpu_s": 2}}
    for path in whole.artifact(NAMES[-1]).iterdir():
        assert path.read_bytes() == again.artifact(f"{NAMES[-1]}/{path.name}").read_bytes()


def killed_in_a_second_leg(learn_iteration):
    def killed(task, settings, seed, iteration, *rest):
        if iteration == 1:
            raise RuntimeError("killed")
        return learn_iteration(task, settings, seed, iteration, *rest)

    return killed


def test_a_simulator_that_is_not_shipped_is_an_error_that_names_it(tmp_path):
    unknown = GROUP.model_copy(update={"simulators": ["imperfect_d"]})

    with pytest.raises(InputError, match=r"imperfect_d.*did you mean imperfect_"):
        train_policy(prepared(tmp_path, {"plain": unknown}))

    assert list(tmp_path.rglob("*")) == []
