"""A report without its run is refused before MLflow is asked."""

import pytest

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.tracking.lineage import origin_of

PIPELINE = "stages: {segment: {cmd: a, outs: [reports/segment/contents.json: {cache: false}]}}"


@pytest.fixture
def root(tmp_path):
    """A repository with a stage and its report."""
    (tmp_path / "reports" / "segment").mkdir(parents=True)
    (tmp_path / "dvc.yaml").write_text(PIPELINE)
    return tmp_path


def test_a_fingerprint_is_no_pattern_that_any_run_fits(root):
    path = root / "reports" / "segment" / "contents.json"
    path.write_text('{"stage": "segment", "command": "a", "fingerprint": "%", "items": []}')
    with pytest.raises(InputError, match=r"contents\.json, fingerprint"):
        origin_of(root, path)


@pytest.mark.parametrize("content", ["{}", "7", "stages: [a]", "stages: {segment: {outs: [7]}}"])
def test_a_broken_dvc_yaml_is_one_error(root, content):
    (root / "dvc.yaml").write_text(content)
    with pytest.raises(InputError, match=r"dvc\.yaml"):
        origin_of(root, root / "reports" / "segment")


def test_where_no_stage_has_run_no_store_is_made(root, monkeypatch):
    monkeypatch.delenv("MLFLOW_TRACKING_URI", raising=False)
    path = root / "reports" / "segment" / "contents.json"
    path.write_text('{"stage": "segment", "command": "a", "fingerprint": "0a", "items": []}')
    with pytest.raises(InputError, match=r"mlflow\.db: is missing, because no stage has run here"):
        origin_of(root, path)
    assert not (root / "mlflow.db").exists()
