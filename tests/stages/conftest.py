"""Small runs, made once: every batch of the arena takes a second, however little is kept of it."""

import shutil

import pytest

from tests.stages.small_runs import run_ingest, run_segment


@pytest.fixture(scope="session")
def ingested(tmp_path_factory):
    """What `ingest` left; not to be changed."""
    root = tmp_path_factory.mktemp("ingested")
    run_ingest(root)
    return root


@pytest.fixture(scope="session")
def segmented(ingested, tmp_path_factory):
    """What `ingest` and `segment` left; not to be changed."""
    root = tmp_path_factory.mktemp("segmented")
    shutil.copytree(ingested, root, dirs_exist_ok=True)
    run_segment(root)
    return root
