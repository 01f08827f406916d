"""Policies are trained side by side, and killed runs go on, to the same bits."""

import multiprocessing
import os
import signal
import threading

import pandas as pd
import pytest
from filelock import FileLock

from models.policy import learning
from models.policy.random_streams import watched_balls
from models.policy.trial import play
from pipeline.policies import training as policy_training
from pipeline.policies.training import Pupil, train_policies, try_policies
from tests.models.policy.schooling import BRIEF, same
from tests.pipeline.trained_policies import description

DESCRIPTIONS = [
    description(),
    description(simulator="imperfect_a", learning=BRIEF.model_copy(update={"legs": 2})),
]


@pytest.fixture(autouse=True)
def one_process(monkeypatch):
    """Train in this process, where other processes would take seconds to start."""
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "1")
    monkeypatch.setattr(policy_training, "TRIALS", 6)


def pupils(root):
    return [Pupil(one, root / one.name) for one in DESCRIPTIONS]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """What comes of both policies; not to be changed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LOKY_MAX_CPU_COUNT", "1")
        patch.setattr(policy_training, "TRIALS", 6)
        return train_policies(pupils(tmp_path_factory.mktemp("undisturbed")))


def assert_same(graduates, others):
    for one, other in zip(graduates, others, strict=True):
        assert one.description == other.description
        assert same(one.policy, other.policy)
        pd.testing.assert_frame_equal(one.curve, other.curve, check_exact=True)


def test_every_policy_goes_through_its_own_legs(undisturbed):
    assert [one.description for one in undisturbed] == DESCRIPTIONS
    assert [one.curve["ticks"].tolist() for one in undisturbed] == [[48, 96, 144], [48, 96]]
    assert all(one.seconds > 0 for one in undisturbed)
    assert not same(undisturbed[0].policy, undisturbed[1].policy)


def test_the_curve_ends_with_how_the_policy_plays(undisturbed):
    for one in undisturbed:
        task = one.description.task
        balls, goals = task.practice(6, watched_balls(one.description.seed))
        played = play(one.policy, task.simulator, balls, goals, task.observation)
        last = one.curve.iloc[-1]
        assert last["hit_rate"] == played["hit"].mean()
        assert last["return_rate"] == played["returned"].mean()


class Killed(BaseException):
    """What ends a process."""


def killing(place, number):
    """Return a ``learn_leg`` whose ``number``-th call is killed, before or after it learns."""
    learn_leg, calls = learning.learn_leg, []

    def killed(*arguments):
        calls.append(arguments)
        if len(calls) == number and place == "before":
            raise Killed
        policy = learn_leg(*arguments)
        if len(calls) == number:
            raise Killed
        return policy

    return killed


@pytest.mark.parametrize("place", ["before", "after"])
@pytest.mark.parametrize("number", [1, 4])
def test_a_killed_run_goes_on_to_the_same_bits(tmp_path, monkeypatch, undisturbed, place, number):
    with monkeypatch.context() as patch, pytest.raises(Killed):
        patch.setattr(learning, "learn_leg", killing(place, number))
        train_policies(pupils(tmp_path))
    assert sum(pupil.legs_done for pupil in pupils(tmp_path)) == number - 1

    assert_same(train_policies(pupils(tmp_path)), undisturbed)


def killed_for_good(root):
    def kill(*_):
        os.kill(os.getpid(), signal.SIGKILL)

    policy_training._watched = kill  # when the learner is written, and the leg is not done
    train_policies(pupils(root))


def test_what_a_killed_process_leaves_behind_is_in_nobodys_way(tmp_path, undisturbed):
    process = multiprocessing.get_context("fork").Process(target=killed_for_good, args=[tmp_path])
    process.start()
    process.join()
    assert process.exitcode == -signal.SIGKILL
    assert list(tmp_path.rglob("learner.zip"))

    assert_same(train_policies(pupils(tmp_path)), undisturbed)


def test_a_finished_training_is_not_done_again(tmp_path, monkeypatch):
    first = train_policies(pupils(tmp_path))
    monkeypatch.delattr(learning, "learn_leg")

    assert_same(train_policies(pupils(tmp_path)), first)


def test_learners_are_kept_no_longer_than_they_are_needed(tmp_path):
    train_policies(pupils(tmp_path))

    folders = {path.parent for path in tmp_path.rglob("replay.pkl")}

    assert folders == {one.leg(one.description.learning.legs - 1) for one in pupils(tmp_path)}


def test_a_leg_that_a_killed_run_is_still_at_is_waited_for(tmp_path, monkeypatch, undisturbed):
    """Its workers may outlive it; two at the same leg would take each other's learner away."""
    pupil = pupils(tmp_path)[1]
    results = []
    waiting = threading.Thread(target=lambda: results.extend(train_policies([pupil])))
    with FileLock(pupil.folder / "lock"):
        waiting.start()
        waiting.join(0.5)
        assert not list(pupil.folder.glob("leg_*"))
        policy_training._learn_on(pupil, 0, None)
        learnt = (pupil.leg(0) / "record.json").stat().st_mtime_ns
    waiting.join()

    assert_same(results, undisturbed[1:])
    assert (pupil.leg(0) / "record.json").stat().st_mtime_ns == learnt


def test_a_policy_is_tried_on_balls_that_it_was_never_watched_on(undisturbed):
    tables = try_policies(undisturbed, 6)

    for one, table in zip(undisturbed, tables, strict=True):
        task = one.description.task
        watched = task.practice(6, watched_balls(one.description.seed))[1].landing[:, 0]
        assert table["ball"].tolist() == list(range(6))
        assert (table["horizons_ms"] == one.description.horizons_label).all()
        assert not set(watched) & set(table["goal_landing_across"])
    pd.testing.assert_frame_equal(tables[0], try_policies(undisturbed, 6)[0], check_exact=True)


@pytest.mark.slow
def test_it_does_not_matter_how_many_processes_there_are(tmp_path, monkeypatch):
    monkeypatch.undo()  # workers watch policies on as many balls as ever
    trained, tried = [], []
    for processes in ("1", "2"):
        monkeypatch.setenv("LOKY_MAX_CPU_COUNT", processes)
        trained.append(train_policies(pupils(tmp_path / processes)))
        tried.append(try_policies(trained[0], 9))

    assert_same(*trained)
    for one, other in zip(*tried, strict=True):
        pd.testing.assert_frame_equal(one, other, check_exact=True)
