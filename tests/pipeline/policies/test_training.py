"""Policies are trained side by side, and killed runs go on, to the same bits."""

import multiprocessing
import os
import signal
import threading

import pandas as pd
import pytest
from filelock import FileLock

from rallygap.models.policy import learning
from rallygap.models.policy.random_streams import validation_stream
from rallygap.pipeline.policies import training as policy_training
from rallygap.pipeline.policies.training import TrainingJob, play_test_shots, train_policies
from tests.models.policy.schooling import BRIEF, same
from tests.pipeline.trained_policies import description

DESCRIPTIONS = [
    description(),
    description(simulator="imperfect_a", learning=BRIEF.model_copy(update={"iterations": 2})),
]


@pytest.fixture(autouse=True)
def one_process(monkeypatch):
    """Train in this process, where other processes would take seconds to start."""
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "1")
    monkeypatch.setattr(policy_training, "VALIDATION_SHOTS", 6)


def jobs(root):
    return [TrainingJob(one, root / one.name) for one in DESCRIPTIONS]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """What comes of both policies; not to be changed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LOKY_MAX_CPU_COUNT", "1")
        patch.setattr(policy_training, "VALIDATION_SHOTS", 6)
        return train_policies(jobs(tmp_path_factory.mktemp("undisturbed")))


def assert_same(results, others):
    for one, other in zip(results, others, strict=True):
        assert one.description == other.description
        assert same(one.policy, other.policy)
        pd.testing.assert_frame_equal(one.curve, other.curve, check_exact=True)


def test_every_policy_goes_through_its_own_iterations(undisturbed):
    assert [one.description for one in undisturbed] == DESCRIPTIONS
    assert [one.curve["control_steps"].tolist() for one in undisturbed] == [[48, 96, 144], [48, 96]]
    assert all(one.seconds > 0 for one in undisturbed)
    assert not same(undisturbed[0].policy, undisturbed[1].policy)


class Killed(BaseException):
    """What ends a process."""


def killing(place, number):
    """Return a ``learn_iteration`` whose ``number``-th call is killed before or after learning."""
    learn_iteration, calls = learning.learn_iteration, []

    def killed(*arguments):
        calls.append(arguments)
        if len(calls) == number and place == "before":
            raise Killed
        policy = learn_iteration(*arguments)
        if len(calls) == number:
            raise Killed
        return policy

    return killed


@pytest.mark.parametrize(("place", "number"), [("after", 1), ("before", 4)])
def test_a_killed_run_goes_on_to_the_same_bits_and_a_finished_one_is_not_done_again(
    tmp_path, monkeypatch, undisturbed, place, number
):
    with monkeypatch.context() as patch, pytest.raises(Killed):
        patch.setattr(learning, "learn_iteration", killing(place, number))
        train_policies(jobs(tmp_path))
    assert sum(job.iterations_done for job in jobs(tmp_path)) == number - 1
    assert_same(train_policies(jobs(tmp_path)), undisturbed)
    monkeypatch.delattr(learning, "learn_iteration")
    assert_same(train_policies(jobs(tmp_path)), undisturbed)


def killed_for_good(root):
    def kill(*_):
        os.kill(os.getpid(), signal.SIGKILL)

    policy_training._play = kill  # when the learner is written, and the iteration is not done
    train_policies(jobs(root))


def test_what_a_killed_process_leaves_behind_is_in_nobodys_way(tmp_path, undisturbed):
    process = multiprocessing.get_context("fork").Process(target=killed_for_good, args=[tmp_path])
    process.start()
    process.join()
    assert process.exitcode == -signal.SIGKILL
    assert list(tmp_path.rglob("learner.zip"))

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


def test_a_policy_is_tried_on_balls_that_it_was_never_watched_on(undisturbed):
    tables = [one.table for one in play_test_shots(undisturbed, 6)]
    for one, table in zip(undisturbed, tables, strict=True):
        task = one.description.task
        watched = task.draw(6, validation_stream(one.description.seed))[1].landing[:, 0]
        assert table["ball"].tolist() == list(range(6))
        assert (table["horizons_ms"] == one.description.horizons_label).all()
        assert not set(watched) & set(table["goal_landing_across"])
    again = play_test_shots(undisturbed[:1], 6)[0].table
    pd.testing.assert_frame_equal(tables[0], again, check_exact=True)
