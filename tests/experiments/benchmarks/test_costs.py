"""Costs of predictors: latency, size and training time."""

import shutil
from itertools import count
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pandas as pd
import pytest

from experiments.benchmarks import costs
from rallygap.pipeline.io.artifacts import write_json, write_table
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import provenance, short
from tests.pipeline.measured_shots import write_inputs

REPOSITORY = Path(__file__).parents[3]


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
    write_table(root / costs.ERRORS, pd.DataFrame(rows, columns=columns))


def test_latency_is_of_every_call(monkeypatch):
    ticks = count(step=0.002)
    monkeypatch.setattr(costs, "time", Mock(perf_counter=lambda: next(ticks)))
    predictor = Mock()
    assert costs.latency(predictor, [None] * 20) == pytest.approx(np.full(20, 2.0))
    assert predictor.predict.call_count == 40  # with the warm-up


def test_every_predictor_of_the_first_set_is_measured(root, monkeypatch):
    monkeypatch.setattr(costs, "CALLS", 30)
    monkeypatch.setattr(costs, "WARM_UP", 3)
    with pytest.raises(InputError, match=r"evaluate_predictor.*run the stage that writes it"):
        costs.measure_costs(root)
    write_errors(root)
    found = costs.measure_costs(root).set_index("predictor")
    assert set(found.index) == {
        "physics_c", "physics_c_with_net", "physics_literature", "filterpy_c", "oracle", "tiny",
    }  # fmt: skip
    assert (found["latency_ms_median"] > 0).all()
    assert (found["latency_ms_p99"] >= found["latency_ms_median"]).all()
    # Of all windows, against what was measured; not all are in the table.
    assert list(found.loc["tiny", found.columns.str.startswith("position")]) == [12.5] * 3
    assert np.isnan(found.loc["physics_c", "position_error_mm_300ms"])
    assert found["training_s"].dropna().to_dict() == {"tiny": 61.5}
    assert list(found["parameters"].dropna().index) == ["tiny"]
