"""Costs of predictors: latency, size and training time."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
import pytest
import torch

from experiments.benchmarks.costs import ERRORS, latency, measure_costs, one_core
from rallygap.models.predictors.protocol import History
from rallygap.pipeline.io.artifacts import write_json, write_table
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import provenance, short
from tests.pipeline.measured_shots import write_inputs

REPOSITORY = Path(__file__).parents[3]


class Slow:
    """Takes 2 ms a ball, and 50 ms for the first, by a clock of its own."""

    def __init__(self):
        self.calls, self.now = 0, 0.0

    def predict(self, history):
        self.calls += 1
        self.now += 0.050 if self.calls == 1 else 0.002

    def perf_counter(self):
        return self.now


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    """A repository after a run, with one set whose physics is known."""
    made = tmp_path_factory.mktemp("repository")
    write_inputs(made, sources=("arena",))
    shutil.copy(REPOSITORY / "params.yaml", made)
    stage = "stages: {train_predictor: {cmd: a, deps: [params.yaml], params: [seed]}}"
    (made / "dvc.yaml").write_text(stage)
    present = short(provenance(made, "train_predictor").fingerprint)
    for name, seconds in ((present, 61.5), ("another run", 7.0)):
        times = {"tiny": {"training_s": seconds}}
        write_json(made / "timings" / "train_predictor" / f"{name}.json", times)
    return made


def write_errors(root):
    rows = [
        ("arena", against, predictor, "position", bounce, horizon, mean)
        for against, bounce, mean in (
            ("measured", "all", 12.5), ("truth", "all", 1.0), ("measured", "with", 2.0),
        )
        for predictor in ("tiny", "oracle")
        for horizon in (100, 200, 300)
    ]  # fmt: skip
    columns = ["set", "against", "predictor", "quantity", "bounce", "horizon_ms", "mean"]
    write_table(root / ERRORS, pd.DataFrame(rows, columns=columns))


def test_latency_is_of_every_call_after_the_warm_up(monkeypatch):
    slow = Slow()
    monkeypatch.setattr("experiments.benchmarks.costs.time", slow)
    balls = [History(np.zeros((1, 12, 6)), np.zeros((1, 12, 6), bool))] * 20
    assert latency(slow, balls) == pytest.approx(np.full(20, 2.0))


def test_every_predictor_of_the_first_set_is_measured(root, monkeypatch):
    monkeypatch.setattr("experiments.benchmarks.costs.CALLS", 30)
    monkeypatch.setattr("experiments.benchmarks.costs.WARM_UP", 3)
    with pytest.raises(InputError, match=r"evaluate_predictor.*run the stage that writes it"):
        measure_costs(root)
    write_errors(root)
    costs = measure_costs(root).set_index("predictor")
    assert set(costs.index) == {
        "physics_c", "physics_c_with_net", "physics_literature", "filterpy_c", "oracle", "tiny",
    }  # fmt: skip
    assert (costs["latency_ms_median"] > 0).all()
    assert (costs["latency_ms_p99"] >= costs["latency_ms_median"]).all()
    # Of all windows, against what was measured; not all are in the table.
    assert list(costs.loc["tiny", costs.columns.str.startswith("position")]) == [12.5] * 3
    assert np.isnan(costs.loc["physics_c", "position_error_mm_300ms"])
    assert costs["training_s"].dropna().to_dict() == {"tiny": 61.5}
    assert list(costs["parameters"].dropna().index) == ["tiny"]


def test_one_core_is_given_back():
    process, threads = psutil.Process(), torch.get_num_threads()
    before = process.cpu_affinity()
    with one_core():
        assert torch.get_num_threads() == 1
        assert len(process.cpu_affinity()) == 1
    assert (process.cpu_affinity(), torch.get_num_threads()) == (before, threads)
