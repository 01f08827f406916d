"""Servers on loopback for tests that need real ones; those tests skip where there is none."""

import os
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.request
import uuid
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

USER, PASSWORD = "rallygap", "open-sesame"  # the password of a server that lives for some tests
PATIENCE = 600  # s, for a server to answer on a busy machine


def program(name):
    """A program of PostgreSQL, which Debian keeps off the path; None where it is not installed."""
    places = sorted(Path("/usr/lib/postgresql").glob(f"*/bin/{name}"), reverse=True)
    return shutil.which(name) or next(map(str, places), None)


def as_server(*command):
    """Run a program of PostgreSQL, which refuses to work for root."""
    other = ["runuser", "-u", "postgres", "--"] if os.geteuid() == 0 else []
    done = subprocess.run([*other, *command], cwd="/", capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def listening(pid):
    """Addresses on which a process or one below it listens; processes that have ended have none."""
    found = set()
    for process in [psutil.Process(pid), *psutil.Process(pid).children(recursive=True)]:
        with suppress(psutil.Error):
            connections = process.net_connections("inet")
            found |= {one.laddr.ip for one in connections if one.status == psutil.CONN_LISTEN}
    return found


def await_answer(url):
    """Wait until a server that was just started answers; return its answer."""
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            with urllib.request.urlopen(url, timeout=5) as answer:
                return answer.read()
        except OSError:
            assert time.monotonic() < deadline
            time.sleep(0.2)


@pytest.fixture(scope="session")
def empty_store(tmp_path_factory):
    """A store of runs that MLflow made, to be copied: that takes seconds."""
    from mlflow import MlflowClient

    path = tmp_path_factory.mktemp("store") / "mlflow.db"
    MlflowClient(f"sqlite:///{path}").search_experiments()
    return path


@pytest.fixture(scope="session")
def postgres_server():
    """The URL of a PostgreSQL server on loopback that asks for a password; without a database."""
    initdb, pg_ctl = program("initdb"), program("pg_ctl")
    if initdb is None or pg_ctl is None:
        pytest.skip("PostgreSQL is not installed")
    home, port = Path(tempfile.mkdtemp(prefix="postgres-")), free_port()
    cluster, secret = home / "cluster", home / "password"
    secret.write_text(PASSWORD)
    if os.geteuid() == 0:
        shutil.chown(home, "postgres")
        shutil.chown(secret, "postgres")
    users = ["--auth=scram-sha-256", f"--username={USER}", f"--pwfile={secret}"]
    as_server(initdb, f"--pgdata={cluster}", "--no-sync", *users)
    where = f"-h 127.0.0.1 -p {port} -c unix_socket_directories='' -c fsync=off"
    options = [f"--log={home / 'log'}", f"--options={where}", "--wait"]
    as_server(pg_ctl, f"--pgdata={cluster}", *options, "start")
    yield f"postgresql://{USER}:{PASSWORD}@127.0.0.1:{port}"
    as_server(pg_ctl, f"--pgdata={cluster}", "--mode=immediate", "stop")
    shutil.rmtree(home)


@pytest.fixture
def postgres_url(postgres_server):
    """The URL of a fresh database on that server."""
    import psycopg

    name = f"t{uuid.uuid4().hex}"
    with psycopg.connect(f"{postgres_server}/postgres", autocommit=True) as connection:
        connection.execute(f"CREATE DATABASE {name}")
    return f"{postgres_server}/{name}"
