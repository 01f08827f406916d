"""Games with larger spins."""

import numpy as np
import pytest

from rallygap.models.arena.rallies import EventLog
from rallygap.pipeline.experiments.simulators import larger_spins


def test_spins_are_larger_and_bend_paths_more(monkeypatch):
    monkeypatch.setattr(larger_spins, "POINTS", 60)
    monkeypatch.setattr(larger_spins, "LEVELS", ("club",))
    content = larger_spins.larger_spins()
    usual, larger = content["club"]
    assert larger["spin_median"] == pytest.approx(1.7 * usual["spin_median"], rel=0.15)
    assert larger["bend_mm"] > 1.2 * usual["bend_mm"]
    assert sum(larger["ended_by"].values()) == pytest.approx(1.0, abs=0.01)


def test_strokes_in_rallies_are_all_but_the_serves():
    """A log of two points: one of three strokes, one of a serve alone."""
    kinds = ["launch", "racket", "table", "racket", "racket", "racket"]
    log = EventLog(2)
    for number, (point, kind) in enumerate(zip([0, 0, 0, 0, 0, 1], kinds, strict=True)):
        log.add(np.array([point]), np.array([float(number)]), kind, np.full((1, 9), float(number)))
    assert larger_spins._strokes(log)[:, 0].tolist() == [3.0, 4.0]
