"""What several machines share: a DVC remote, and an MLflow server on PostgreSQL."""

import asyncio
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import asyncssh
import pytest
from mlflow import MlflowClient

from rallygap.pipeline.runtime.provenance import Provenance
from rallygap.pipeline.tracking.recording import recorded
from rallygap.pipeline.tracking.results import Results
from tests.clone import ROOT, commit, run
from tests.services import free_port, listening

pytestmark = pytest.mark.slow

STAGE = """
stages:
  write:
    cmd: python -c "open('balls.bin', 'wb').write(bytes(range(256)) * 1000)"
    deps: [seed.txt]
    outs: [balls.bin]
"""


@pytest.fixture
def repository(tmp_path):
    """A repository with this one's configuration of DVC and one small stage, run and committed."""
    folder = tmp_path / "mine"
    (folder / ".dvc").mkdir(parents=True)
    for name in (".dvc/config", ".dvc/.gitignore"):
        shutil.copy(ROOT / name, folder / name)
    (folder / "dvc.yaml").write_text(STAGE)
    (folder / "seed.txt").write_text("1")
    run(folder, "git", "init", "--quiet")
    run(folder, "dvc", "repro", "--quiet")
    commit(folder, "run")
    return folder


@pytest.fixture(params=["folder", "ssh"])
def remote(request, tmp_path):
    """A place that all machines reach, and what DVC has to know of it besides."""
    place = tmp_path / "remote"
    if request.param == "folder":
        yield str(place), {}
        return
    place.mkdir()
    key = tmp_path / "key"
    with file_server(place, key) as port:
        yield f"ssh://127.0.0.1:{port}/lab", {"user": "me", "keyfile": str(key)}


@contextmanager
def file_server(folder, path):
    """An SSH server of a folder on loopback, for whoever has the key at a path; yields its port."""
    key = asyncssh.generate_private_key("ssh-ed25519")
    key.write_private_key(path)
    key.write_public_key(path.with_suffix(".pub"))
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    server = listening_server(folder, path.with_suffix(".pub"))
    try:
        yield asyncio.run_coroutine_threadsafe(server, loop).result().get_port()
    finally:
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        loop.close()


async def listening_server(folder, keys):
    return await asyncssh.listen(
        "127.0.0.1",
        0,
        server_host_keys=[asyncssh.generate_private_key("ssh-ed25519")],
        authorized_client_keys=str(keys),
        sftp_factory=lambda channel: asyncssh.SFTPServer(channel, chroot=os.fsencode(folder)),
    )


def use(repository, remote):
    """Make a place the remote of a repository, as docs/scale.md does."""
    url, settings = remote
    run(repository, "dvc", "remote", "add", "--local", "--default", "lab", url)
    for name, value in settings.items():
        run(repository, "dvc", "remote", "modify", "--local", "lab", name, value)


def test_results_go_through_a_remote_to_another_machine(repository, remote, tmp_path):
    other = tmp_path / "theirs"
    use(repository, remote)
    run(repository, "dvc", "push")
    assert run(repository, "git", "status", "--short") == ""  # nobody else's path is committed

    run(tmp_path, "git", "clone", "--quiet", str(repository), str(other))
    use(other, remote)
    run(other, "dvc", "pull")

    assert (other / "balls.bin").read_bytes() == (repository / "balls.bin").read_bytes()
    assert "up to date" in run(other, "dvc", "repro")


@contextmanager
def tracking_server(store, folder):
    """MLflow's server as docs/scale.md starts it; yields its URL and process."""
    port = free_port()
    command = [sys.executable, "-m", "mlflow", "server", "--host", "127.0.0.1", "--port", port]
    command += ["--workers", "1", "--backend-store-uri", store, "--artifacts-destination", folder]
    environment = {**os.environ, "MLFLOW_DISABLE_TELEMETRY": "true", "DO_NOT_TRACK": "true",
                   "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false"}  # fmt: skip
    log = (folder.parent / "server.log").open("w")
    process = subprocess.Popen(
        list(map(str, command)), env=environment, stdout=log, stderr=log, start_new_session=True
    )
    try:
        url = f"http://127.0.0.1:{port}"
        _wait_for(url, process)
        yield url, process
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait()


def _wait_for(url, process):
    deadline = time.monotonic() + 600  # on a busy machine
    while time.monotonic() < deadline and process.poll() is None:
        try:
            urllib.request.urlopen(f"{url}/health", timeout=5).read()
            return
        except OSError:
            time.sleep(0.5)
    raise AssertionError("the server did not start")


def test_runs_and_figures_are_kept_by_a_server_on_postgresql(
    postgres_url,
    tmp_path,
    monkeypatch,
):
    """They outlive the server, which listens on loopback alone."""
    store, figure = tmp_path / "figures", tmp_path / "cuts.png"
    store.mkdir()
    figure.write_bytes(b"drawn")
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_TIMEOUT", "120")
    results = Results({"tt3d": {"mean": 1.5}}, figures=[figure])
    with tracking_server(postgres_url, store) as (url, process):
        monkeypatch.setenv("MLFLOW_TRACKING_URI", url)
        origin = Provenance("python -m rallygap.stages.segment", "f" * 64)
        with recorded("segment", origin, {"seed": 1}, lambda: results):
            pass
        assert listening(process.pid) == {"127.0.0.1"}
    assert [path.read_bytes() for path in store.rglob("cuts.png")] == [b"drawn"]

    with tracking_server(postgres_url, store) as (url, _):
        client = MlflowClient(url)
        experiment = client.get_experiment_by_name("rallygap")
        (found,) = client.search_runs([experiment.experiment_id])
        assert (found.info.run_name, found.info.status) == ("segment", "FINISHED")
        assert (found.data.params, found.data.metrics) == ({"seed": "1"}, {"tt3d/mean": 1.5})
        copy = client.download_artifacts(found.info.run_id, "figures/cuts.png", str(tmp_path))
        assert Path(copy).read_bytes() == b"drawn"
