"""Workers here do not record their trials, which would start a process for each."""

import pytest

from pipeline.sweeps import worker
from tests.pipeline.sweeps.made_up import unrecorded


@pytest.fixture(autouse=True)
def no_records(monkeypatch):
    monkeypatch.setattr(worker, "recorded_trial", unrecorded)
    monkeypatch.setattr(worker, "LOOK_AGAIN", 0.1)
