"""Parallel tasks: on the cores of this machine, or on a cluster.

The environment variable ``RALLYGAP_CLUSTER`` has the address of a scheduler of dask.distributed,
such as ``tcp://127.0.0.1:8786``; without it, joblib uses all cores. Results depend neither on
where tasks run nor on how many run at once: each has one thread, and results keep their order.
"""

import hashlib
import os
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from joblib import Parallel, cpu_count, delayed
from threadpoolctl import threadpool_limits

from rallygap.pipeline.runtime.determinism import hold_arithmetic
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.progress import progress

if TYPE_CHECKING:
    from distributed import Client

Result = TypeVar("Result")

CLUSTER = "RALLYGAP_CLUSTER"
PATIENCE = 30  # s, that a cluster may take to answer
CODE = ("experiments", "models", "pipeline", "stages")


def parallel(
    tasks: Sequence[Callable[[], Result]], description: str = "", done: int = 0
) -> Iterator[Result]:
    """Yield what tasks return, in their order.

    On a cluster, the task of a worker that dies is done by another. Tasks that leave files want a
    folder that every machine has under the same path.

    Args:
        tasks: callables without arguments that can be pickled.
        description: of a progress bar; there is none without it.
        done: number of other tasks that an earlier run has done, for the progress bar.

    Raises:
        InputError: there is no such cluster, or it is lost, or it would give other results.
    """
    address = os.environ.get(CLUSTER)
    results = _on_cluster(address, tasks) if address else _on_cores(tasks)
    return progress(results, description, len(tasks) + done, done) if description else results


def make_missing(tasks: Mapping[Path, Callable[[], None]], description: str) -> None:
    """Do in parallel the tasks whose files are not there; each leaves its file."""
    pending = [task for file, task in tasks.items() if not file.exists()]
    for _ in parallel(pending, description, done=len(tasks) - len(pending)):
        pass


def _on_cores(tasks: Sequence[Callable[[], Result]]) -> Iterator[Result]:
    # loky says so when it replaces a process whose memory has grown.
    warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
    # No more processes than tasks, because each takes seconds to start; and without memory maps,
    # which torch warns of because it could not write to them.
    processes = max(1, min(cpu_count(), len(tasks)))
    joblib = Parallel(processes, return_as="generator", max_nbytes=None)
    yield from joblib(delayed(_on_one_thread)(task) for task in tasks)


def _on_cluster(address: str, tasks: Sequence[Callable[[], Result]]) -> Iterator[Result]:
    try:
        from distributed import Client
        from distributed.comm.core import CommClosedError
    except ImportError:
        problem = "needs dask.distributed; install rallygap with the extra `cluster`"
        raise InputError(CLUSTER, problem) from None
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        problem = f"no scheduler answers at {address}: {' '.join(str(error).split())}"
        raise InputError(CLUSTER, problem) from None
    with client:
        _check_workers(client)
        # Not pure: equal tasks of two runs are two tasks.
        waiting = deque(client.map(_on_one_thread, tasks, pure=False))
        while waiting:
            try:
                result = waiting.popleft().result()
            except (CancelledError, CommClosedError):
                problem = f"the scheduler {address} was lost; what is done is kept, run again"
                raise InputError(CLUSTER, problem) from None
            yield result


def _on_one_thread(task: Callable[[], Result]) -> Result:
    """Do a task with one thread, since sums of more differ in their last bits."""
    with threadpool_limits(1):
        return task()


def _check_workers(client: "Client") -> None:
    """Refuse a cluster without workers, and workers that would give other results."""
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        raise InputError(CLUSTER, "has no workers; start some with `dask worker`") from None
    for worker, threads in client.nthreads().items():  # type: ignore[no-untyped-call]
        if threads != 1:
            problem = f"has {threads} threads; start it with --nthreads 1"
            raise InputError(CLUSTER, problem, field=worker)
    # Also of those that join later.
    client.register_worker_callbacks(hold_arithmetic)  # type: ignore[no-untyped-call]
    ours = code_digest()
    for worker, digest in client.run(code_digest).items():
        if digest != ours:
            problem = "runs other code; check out the same commit there and restart it"
            raise InputError(CLUSTER, problem, field=worker)


def code_digest() -> str:
    """Return a digest of the code that tasks run on."""
    digest = hashlib.sha256()
    home = Path(__file__).parents[2]
    for path in sorted(path for name in CODE for path in (home / name).rglob("*.py")):
        digest.update(path.relative_to(home).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()
