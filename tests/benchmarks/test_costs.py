"""Costs of predictors: latency, size and training time."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
import pytest
import torch

from experiments.benchmarks.costs import (
    latency,
    measure_costs,
    one_core,
)
from rallygap.models.predictors.protocol import History
from rallygap.pipeline.evaluation.error_table import KEYS, NUMBERS, REPORT
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import provenance, short
from tests.pipeline.measured_shots import write_inputs

REPOSITORY = Path(__file__).parents[2]


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
    rows = [
        ("arena", against, predictor, "position", bounce, horizon, mean, mean, 1.0, 9, mean, mean)
        for against, bounce, mean in (
            ("measured", "all", 12.5), ("truth", "all", 1.0), ("measured", "with", 2.0),
        )
        for predictor in ("tiny", "oracle")
        for horizon in (100, 200, 300)
    ]  # fmt: skip
    (made / REPORT).parent.mkdir(parents=True)
    pd.DataFrame(rows, columns=[*KEYS, *NUMBERS]).to_csv(made / REPORT, index=False)
    stage = "stages: {train_predictor: {cmd: a, deps: [params.yaml], params: [seed]}}"
    (made / "dvc.yaml").write_text(stage)
    present = short(provenance(made, "train_predictor").fingerprint)
    for name, seconds in ((present, 61.5), ("another run", 7.0)):
        times = {"tiny": {"training_s": seconds}}
        write_json(made / "timings" / "train_predictor" / f"{name}.json", times)
    return made


@pytest.fixture(scope="module")
def costs(root):
    """What is measured there, with few calls."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("experiments.benchmarks.costs.CALLS", 30)
        patch.setattr("experiments.benchmarks.costs.WARM_UP", 3)
        return measure_costs(root)


def test_latency_is_of_every_call_after_the_warm_up(monkeypatch):
    slow = Slow()
    monkeypatch.setattr("experiments.benchmarks.costs.time", slow)
    balls = [History(np.zeros((1, 12, 6)), np.zeros((1, 12, 6), bool))] * 20
    assert latency(slow, balls) == pytest.approx(np.full(20, 2.0))


def test_every_predictor_of_the_first_set_is_measured(costs):
    assert set(costs["predictor"]) == {
        "physics_c", "physics_c_with_net", "physics_literature", "filterpy_c", "oracle", "tiny",
    }  # fmt: skip
    assert (costs["latency_ms_median"] > 0).all()
    assert (costs["latency_ms_p99"] >= costs["latency_ms_median"]).all()


def test_errors_are_those_reported_for_all_windows_against_the_measured_state(costs):
    rows = costs.set_index("predictor")
    assert list(rows.loc["tiny", rows.columns.str.startswith("position")]) == [12.5] * 3
    assert np.isnan(rows.loc["physics_c", "position_error_mm_300ms"])  # not in the report


def test_only_trained_predictors_have_parameters_and_a_time_of_training(costs):
    rows = costs.set_index("predictor")
    assert rows["training_s"].dropna().to_dict() == {"tiny": 61.5}
    assert list(rows["parameters"].dropna().index) == ["tiny"]


def test_one_core_is_given_back():
    process, threads = psutil.Process(), torch.get_num_threads()
    before = process.cpu_affinity()
    with one_core():
        assert torch.get_num_threads() == 1
        assert len(process.cpu_affinity()) == 1
    assert (process.cpu_affinity(), torch.get_num_threads()) == (before, threads)


def test_without_a_finished_run_the_stage_to_run_is_named(tmp_path):
    write_inputs(tmp_path, sources=("arena",))
    shutil.copy(REPOSITORY / "params.yaml", tmp_path)
    with pytest.raises(InputError, match="dvc repro evaluate_predictor"):
        measure_costs(tmp_path)
