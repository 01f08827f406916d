"""A PostgreSQL server on loopback for tests that need one; they skip where it is not installed."""

import os
import shutil
import socket
import subprocess
import tempfile
import uuid
from pathlib import Path

import pytest

USER, PASSWORD = "rallygap", "open-sesame"  # of a server that lives for a few tests


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def program(name):
    """A program of PostgreSQL, which Debian keeps off the path; None where it is not installed."""
    places = sorted(Path("/usr/lib/postgresql").glob(f"*/bin/{name}"), reverse=True)
    return shutil.which(name) or next(map(str, places), None)


def as_server(*command):
    """Run a program of PostgreSQL, which refuses to work for root."""
    other = ["runuser", "-u", "postgres", "--"] if os.geteuid() == 0 else []
    done = subprocess.run([*other, *map(str, command)], cwd="/", capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="session")
def postgres_server():
    """The address of a server that asks for a password, with user and password; no database."""
    initdb, pg_ctl = program("initdb"), program("pg_ctl")
    if initdb is None or pg_ctl is None:
        pytest.skip("PostgreSQL is not installed")
    # Not in pytest's folder, which is root's alone.
    with tempfile.TemporaryDirectory(prefix="postgres-") as home:
        if os.geteuid() == 0:
            shutil.chown(home, "postgres")
        data, secret, port = Path(home, "data"), Path(home, "password"), free_port()
        secret.write_text(PASSWORD)
        secret.chmod(0o644)
        how = ["--auth=scram-sha-256", f"--username={USER}", f"--pwfile={secret}", "--no-sync"]
        as_server(initdb, f"--pgdata={data}", *how)
        options = f"-h 127.0.0.1 -p {port} -c unix_socket_directories='' -c fsync=off"
        server = [pg_ctl, f"--pgdata={data}", "--wait", "--timeout=300"]
        as_server(*server, f"--log={data / 'log'}", f"--options={options}", "start")
        yield f"{USER}:{PASSWORD}@127.0.0.1:{port}"
        as_server(*server, "--mode=immediate", "stop")


@pytest.fixture
def postgres_url(postgres_server):
    """The URL of a fresh database on that server, in SQLAlchemy's words."""
    import psycopg

    name = f"t{uuid.uuid4().hex}"
    with psycopg.connect(f"postgresql://{postgres_server}/postgres", autocommit=True) as connection:
        connection.execute(f"CREATE DATABASE {name}")
    return f"postgresql+psycopg://{postgres_server}/{name}"
