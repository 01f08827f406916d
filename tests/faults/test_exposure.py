"""Nobody else can reach what rallygap starts: it listens on this machine alone."""

import ipaddress
import os
import socket
import time

import pytest

from tests.faults.repository import stages
from tests.services import listening


def beyond_loopback(addresses):
    return {one for one in addresses if not ipaddress.ip_address(one).is_loopback}


def test_the_probe_sees_who_listens_beyond_loopback():
    with socket.create_server(("0.0.0.0", 0)), socket.create_server(("127.0.0.1", 0)):
        assert beyond_loopback(listening(os.getpid())) == {"0.0.0.0"}


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
