"""Policies are trained side by side, and killed runs go on, to the same bits."""

import multiprocessing
import os
import signal
import threading
from itertools import count
from types import SimpleNamespace

import pandas as pd
import pytest
from filelock import FileLock

from rallygap.models.policy import learning
from rallygap.pipeline.policies import training as policy_training
from rallygap.pipeline.policies.training import TrainingJob, train_policies
from tests.models.policy.schooling import BRIEF, same
from tests.pipeline.trained_policies import description

DESCRIPTIONS = [
    description(),
    description(simulator="imperfect_a", learning=BRIEF.model_copy(update={"iterations": 2})),
]


@pytest.fixture(autouse=True, scope="module")
def one_process():
    """Train in this process, where other processes would take seconds to start."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LOKY_MAX_CPU_COUNT", "1")
        patch.setattr(policy_training, "VALIDATION_SHOTS", 6)
        yield


def jobs(root):
    return [TrainingJob(one, root / one.name) for one in DESCRIPTIONS]


@pytest.fixture(scope="module")
def undisturbed(one_process, tmp_path_factory):
    """What comes of both policies; not to be changed."""
    return train_policies(jobs(tmp_path_factory.mktemp("undisturbed")))


def assert_same(results, others):
    for one, other in zip(results, others, strict=True):
        assert one.description == other.description
        assert same(one.policy, other.policy)
        pd.testing.assert_frame_equal(one.curve, other.curve, check_exact=True)


def killed_run(root, place, number):
    """Train until a call of ``learn_iteration`` kills this process before or after learning."""
    learn_iteration, calls = learning.learn_iteration, count(1)

    def killed(*arguments):
        last = next(calls) == number
        if last and place == "before":
            os.kill(os.getpid(), signal.SIGKILL)
        policy = learn_iteration(*arguments)
        if last:
            os.kill(os.getpid(), signal.SIGKILL)
        return policy

    learning.learn_iteration = killed
    train_policies(jobs(root))


@pytest.mark.parametrize(("place", "number"), [("after", 1), ("before", 4)])
def test_a_killed_run_goes_on_to_the_same_bits_and_a_finished_one_is_not_done_again(
    tmp_path, monkeypatch, undisturbed, place, number
):
    clock = SimpleNamespace(process_time=count().__next__)  # a second at every look
    monkeypatch.setattr(policy_training, "time", clock)
    fork = multiprocessing.get_context("fork")
    process = fork.Process(target=killed_run, args=[tmp_path, place, number])
    process.start()
    process.join()
    assert process.exitcode == -signal.SIGKILL
    assert sum(job.iterations_done for job in jobs(tmp_path)) == number - 1
    results = train_policies(jobs(tmp_path))
    assert_same(results, undisturbed)
    assert [one.seconds for one in results] == [3, 2]  # of both runs
    monkeypatch.delattr(learning, "learn_iteration")
    assert_same(train_policies(jobs(tmp_path)), undisturbed)


def test_an_iteration_of_a_killed_run_is_waited_for(tmp_path, monkeypatch, undisturbed):
    """Its workers may outlive it; two at one iteration would delete each other's learner."""
    job = jobs(tmp_path)[1]
    results = []
    waiting = threading.Thread(target=lambda: results.extend(train_policies([job])))
    with FileLock(job.folder / "lock"):
        waiting.start()
        waiting.join(0.5)
        assert not list(job.folder.glob("iteration_*"))
        policy_training._train(job, 0, None)
        learnt = (job.iteration(0) / "record.json").stat().st_mtime_ns
    waiting.join()
    assert_same(results, undisturbed[1:])
    assert (job.iteration(0) / "record.json").stat().st_mtime_ns == learnt
