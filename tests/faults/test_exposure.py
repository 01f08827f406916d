"""Nobody else can reach what rallygap starts: it listens on this machine alone."""

import ipaddress
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from tests.faults.repository import descendants, stages

ROOT = Path(__file__).parents[2]
SECONDS = 300.0  # that the pages may take to come up on a busy machine


def listening(pid):
    """Addresses on which a process or one below it listens."""
    found = set()
    for process in [psutil.Process(pid), *descendants(pid)]:
        try:
            connections = process.net_connections("inet")
        except psutil.Error:
            continue
        found |= {one.laddr.ip for one in connections if one.status == psutil.CONN_LISTEN}
    return found


def beyond_loopback(addresses):
    return {one for one in addresses if not ipaddress.ip_address(one).is_loopback}


def test_the_probe_sees_who_listens_beyond_loopback():
    with socket.create_server(("0.0.0.0", 0)), socket.create_server(("127.0.0.1", 0)):
        assert beyond_loopback(listening(os.getpid())) == {"0.0.0.0"}


@pytest.mark.slow
def test_the_pages_listen_on_loopback_alone(tmp_path):
    (tmp_path / "pyproject.toml").touch()
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    program = "from pipeline.cli import main; main()"
    pages = subprocess.Popen(
        [sys.executable, "-c", program, "ui", "--port", str(port)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT), "DVC_ROOT": str(tmp_path)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        deadline = time.monotonic() + SECONDS
        while not (addresses := listening(pages.pid)):
            assert time.monotonic() < deadline and pages.poll() is None
            time.sleep(0.2)
        time.sleep(2)  # what else comes up
        assert beyond_loopback(addresses | listening(pages.pid)) == set()
    finally:
        for process in [*descendants(pages.pid), pages]:
            process.terminate()
        pages.wait()


@pytest.mark.faults
def test_nothing_listens_beyond_loopback_while_the_pipeline_runs(repository):
    seen = set()
    with repository.without(stages()[0]):
        dvc = repository.start("dvc", "repro", "--force")
        while dvc.poll() is None:
            seen |= listening(dvc.pid)
            time.sleep(0.2)
    assert dvc.returncode == 0
    assert beyond_loopback(seen) == set()
