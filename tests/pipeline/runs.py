"""What a repository's MLflow store holds, and servers that show it."""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager

from mlflow import MlflowClient

from tests.services import await_answer, free_port

RALLYGAP = ["-c", "from rallygap.pipeline.cli import main; main()"]


@contextmanager
def served(*words, **options):
    """Run a server of Python on a port of its own; yield its address and process."""
    port = free_port()
    server = subprocess.Popen(
        [sys.executable, *map(str, words), "--port", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        **options,
    )
    address = f"http://127.0.0.1:{port}"
    try:
        await_answer(f"{address}/health")
        yield address, server
    finally:
        os.killpg(server.pid, signal.SIGTERM)
        server.wait()


def served_pages(repository, code):
    """The server that `rallygap ui` of some code starts in a repository."""
    environment = {**os.environ, "PYTHONPATH": str(code)}
    environment.pop("MLFLOW_TRACKING_URI", None)
    return served(*RALLYGAP, "ui", cwd=repository, env=environment)


def store(repository):
    """A client of the store that the stages of a repository write."""
    return MlflowClient(f"sqlite:///{repository / 'mlflow.db'}")


def runs(repository, query, **options):
    """The runs that a query finds; options are those of MLflow's ``search_runs``."""
    client = store(repository)
    (experiment,) = client.search_experiments(filter_string="name = 'rallygap'")
    return client.search_runs([experiment.experiment_id], query, **options)
