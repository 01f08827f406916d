"""A cluster on loopback: a scheduler and workers, each a process that can be killed."""

import os
import subprocess
import sys
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from distributed import Client

ROOT = Path(__file__).parents[1]
# Without a dashboard, its server still listens, by default to everybody.
LOOPBACK = ["--host", "127.0.0.1", "--no-dashboard", "--dashboard-address", "127.0.0.1:0"]


@dataclass
class Cluster:
    """The address of a scheduler, its process, and those of its workers."""

    address: str
    scheduler: subprocess.Popen
    workers: list[subprocess.Popen] = field(default_factory=list)


@contextmanager
def cluster(folder, workers=2, threads=1, cwd=ROOT):
    """Run a scheduler and so many workers until the end of the block."""
    started = folder / "scheduler.json"
    started.unlink(missing_ok=True)
    with ExitStack() as stack:
        options = [*LOOPBACK, "--port", "0", "--scheduler-file", started]
        scheduler = _run(stack, cwd, "scheduler", *options)
        with Client(scheduler_file=started, timeout=300, set_as_default=False) as client:
            found = Cluster(client.scheduler.address, scheduler)
            options = [*LOOPBACK, "--no-nanny", "--nthreads", threads, "--local-directory", folder]
            found.workers = [
                _run(stack, cwd, "worker", found.address, *options) for _ in range(workers)
            ]
            if workers:
                client.wait_for_workers(workers, timeout=300)
        yield found


def _run(stack, cwd, role, *options):
    environment = {**os.environ, "PYTHONPATH": str(cwd)}
    command = [sys.executable, "-m", "dask", role, *map(str, options)]
    process = subprocess.Popen(
        command, cwd=cwd, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    stack.callback(process.wait)
    stack.callback(process.kill)
    return process
