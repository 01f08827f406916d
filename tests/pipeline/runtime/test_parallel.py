"""Where tasks run makes no difference to what they give: here, on loky, or on a cluster."""

import os
import signal
import socket
import threading
import time
from functools import partial

import pandas as pd
import pytest
from threadpoolctl import threadpool_info

from experiments.clone import ROOT, copy_sources
from rallygap.pipeline.policies.training import TrainingJob, play_test_shots, train_policies
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import CLUSTER, parallel
from tests.cluster import cluster
from tests.models.policy.schooling import BRIEF, same
from tests.pipeline.trained_policies import description
from tests.services import listening


def noted(folder, number):
    """Take a moment; leave a file that says which process did it; return the number."""
    (folder / f"{number}-{os.getpid()}").touch()
    time.sleep(0.05)
    return number


def killing(folder):
    """Kill the worker once, whichever it is."""
    if not (folder / "killed").exists():
        (folder / "killed").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "done by another"


def threads():
    return {pool["num_threads"] for pool in threadpool_info()}


def tasks(folder, count=40):
    return [partial(noted, folder, number) for number in range(count)]


def processes(folder):
    return {int(path.name.split("-")[1]) for path in folder.iterdir()}


@pytest.fixture
def on_cluster(tmp_path_factory, monkeypatch):
    with cluster(tmp_path_factory.mktemp("cluster")) as found:
        monkeypatch.setenv(CLUSTER, found.address)
        yield found


def test_results_come_in_the_order_of_the_tasks_and_each_has_one_thread(tmp_path):
    assert list(parallel([*tasks(tmp_path, 3), threads])) == [0, 1, 2, {1}]


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:{}", "127.0.0.1:{}", "carrier-pigeon://{}"])
def test_an_address_without_a_scheduler_is_one_error(monkeypatch, address):
    monkeypatch.setattr("rallygap.pipeline.runtime.parallel.PATIENCE", 0.5)
    with socket.socket() as taken:  # bound, but nobody listens
        taken.bind(("127.0.0.1", 0))
        address = address.format(taken.getsockname()[1])
        monkeypatch.setenv(CLUSTER, address)
        with pytest.raises(InputError, match=f"{CLUSTER}: no scheduler answers at {address}: "):
            list(parallel([threads]))


@pytest.mark.slow
def test_a_cluster_on_loopback_does_all_tasks_though_workers_are_killed(tmp_path, on_cluster):
    for process in (on_cluster.scheduler, *on_cluster.workers):
        assert listening(process.pid) == {"127.0.0.1"}
    with pytest.raises(ZeroDivisionError, match="by zero"):
        list(parallel([threads, partial(divmod, 1, 0)]))
    assert list(parallel([threads])) == [{1}]
    found = parallel(tasks(tmp_path))
    first = next(found)
    on_cluster.workers[0].kill()
    assert [first, *found] == list(range(40))
    assert {worker.pid for worker in on_cluster.workers} == processes(tmp_path)


@pytest.mark.slow
def test_the_task_that_a_worker_died_of_is_done_by_another_but_a_lost_scheduler_is_one_error(
    tmp_path, on_cluster
):
    assert list(parallel([partial(killing, tmp_path)])) == ["done by another"]
    assert sum(worker.poll() == -signal.SIGKILL for worker in on_cluster.workers) == 1
    running = parallel(tasks(tmp_path, 200))
    next(running)
    on_cluster.scheduler.kill()
    with pytest.raises(InputError, match="was lost; what is done is kept, run again"):
        list(running)


@pytest.mark.slow
def test_no_workers_and_workers_that_would_give_other_results_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("rallygap.pipeline.runtime.parallel.PATIENCE", 5)
    other = tmp_path / "other"
    copy_sources(ROOT, other)
    (other / "models" / "new.py").touch()
    for settings, problem in (
        ({"workers": 0}, "has no workers; start some"),
        ({"workers": 1, "threads": 2}, "has 2 threads; start it with --nthreads 1"),
        ({"workers": 1, "cwd": other}, "runs other code; check out the same commit"),
    ):
        with cluster(tmp_path, **settings) as found:
            monkeypatch.setenv(CLUSTER, found.address)
            with pytest.raises(InputError, match=problem):
                list(parallel([threads]))


def work(root):
    """Train and try two policies."""
    described = [description(), description(simulator="imperfect_a", learning=BRIEF)]
    trained = train_policies([TrainingJob(one, root / one.name) for one in described])
    return trained, play_test_shots(trained, 9)


@pytest.mark.slow
def test_policies_are_the_same_wherever_they_are_trained(tmp_path, monkeypatch, on_cluster):
    """One after the other here, two at once here, and on a cluster that loses a worker."""
    killed, folder = on_cluster.workers[0], tmp_path / "cluster"

    def kill_after_an_iteration():
        while not list(folder.rglob("record.json")):
            time.sleep(0.05)
        killed.kill()

    waiting = threading.Thread(target=kill_after_an_iteration)
    waiting.start()
    results = [work(folder)]
    waiting.join()
    assert killed.poll() == -signal.SIGKILL

    monkeypatch.delenv(CLUSTER)
    for number in ("1", "2"):
        monkeypatch.setenv("LOKY_MAX_CPU_COUNT", number)
        results.append(work(tmp_path / number))

    (trained, played), *others = results
    for policies, trials in others:
        for one, other in zip(policies, trained, strict=True):
            assert same(one.policy, other.policy)
            pd.testing.assert_frame_equal(one.curve, other.curve, check_exact=True)
        for one, other in zip(trials, played, strict=True):
            pd.testing.assert_frame_equal(one.table, other.table, check_exact=True)
