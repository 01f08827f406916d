"""Trials of these tests are not recorded in MLflow unless a test says so."""

from contextlib import nullcontext

import pytest

from rallygap.pipeline.sweeps import study


@pytest.fixture(autouse=True)
def unrecorded(monkeypatch):
    monkeypatch.setattr(study, "tracked_run", lambda *_: nullcontext())
