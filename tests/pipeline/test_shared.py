"""What several machines share: an MLflow server on PostgreSQL; DVC's remote is in daily use."""

import os
from pathlib import Path

import pytest
from mlflow import MlflowClient

from rallygap.pipeline.runtime.provenance import Provenance
from rallygap.pipeline.tracking.results import Results
from rallygap.pipeline.tracking.runs import tracked_stage
from tests.pipeline.runs import served
from tests.services import listening

pytestmark = pytest.mark.slow


def tracking_server(store, folder):
    """MLflow's server as docs/scale.md starts it."""
    environment = {
        **os.environ,
        "MLFLOW_DISABLE_TELEMETRY": "true",
        "DO_NOT_TRACK": "true",
        "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false",
    }
    words = ["-m", "mlflow", "server", "--host", "127.0.0.1", "--workers", "1"]
    words += ["--backend-store-uri", store, "--artifacts-destination", folder]
    return served(*words, env=environment)


def test_runs_and_figures_are_kept_by_a_server_on_postgresql(postgres_url, tmp_path, monkeypatch):
    """They outlive the server, which listens on loopback alone."""
    store, figure = tmp_path / "figures", tmp_path / "cuts.png"
    store.mkdir()
    figure.write_bytes(b"drawn")
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_TIMEOUT", "120")
    results = Results({"tt3d": {"mean": 1.5}}, figures=[figure])
    with tracking_server(postgres_url, store) as (url, process):
        monkeypatch.setenv("MLFLOW_TRACKING_URI", url)
        origin = Provenance("python -m rallygap.stages.segment", "f" * 64)
        with tracked_stage("segment", origin, {"seed": 1}, lambda: results):
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
