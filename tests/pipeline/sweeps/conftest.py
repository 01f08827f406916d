"""Trials here are not recorded, unless a test is about that."""

import pytest

from pipeline.sweeps import worker
from tests.pipeline.sweeps.made_up import unrecorded


@pytest.fixture(autouse=True)
def no_records(monkeypatch, request):
    if "recorded" not in request.keywords:
        monkeypatch.setattr(worker, "recorded_trial", unrecorded)
        monkeypatch.setattr(worker, "LOOK_AGAIN", 0.1)
