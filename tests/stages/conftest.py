"""Small runs, made once: every batch of the arena takes a second, however little is kept of it."""

import pytest

from tests.stages.small_runs import run_ingest


@pytest.fixture(scope="session")
def ingested(tmp_path_factory):
    """What `ingest` left; not to be changed."""
    root = tmp_path_factory.mktemp("ingested")
    run_ingest(root)
    return root
