"""The tables of costs multiply and divide what was measured."""

import shutil
from pathlib import Path

import pandas as pd
import pytest

from rallygap.pipeline.documentation.cost_tables import (
    CORE_HOUR,
    EPOCH,
    extrapolation_table,
    scale_table,
)
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.params import load_params

ROOT = Path(__file__).parents[3]
UNITS = ("episodes", "questions of the exam", "control steps", "windows")


@pytest.fixture
def root(tmp_path):
    """One unit of every work per second, and twice that on two processes."""
    rows = [
        {"work": f"do {unit}", "unit": unit, "processes": processes, "units": units,
         "seconds": units / processes, "per_second": processes}
        for unit in UNITS for processes, units in ((1, 10), (1, 20), (2, 20))
    ]  # fmt: skip
    write_json(tmp_path / "reports/costs/scale.json", {"disk_bytes": 2_000, "memory_bytes": 50_000})
    pd.DataFrame(rows).to_csv(tmp_path / "reports/costs/scale.csv", index=False)
    shutil.copy(ROOT / "params.yaml", tmp_path)
    return tmp_path


def test_the_speed_up_is_that_of_twice_the_work(root):
    first = scale_table(root).splitlines()[2]
    assert first == "| do episodes | episodes | 10 | 10.0 | 20 | 20.0 | 10.0 | 2.00 |"


def test_the_extrapolation_multiplies_rates_and_counts_every_epoch_once(root):
    lines = extrapolation_table(root).splitlines()[2:]
    rows = [[cell.strip() for cell in line.split("|")[1:]] for line in lines]
    values = {row[0]: float(row[1].split()[0].replace(",", "")) for row in rows}
    assert values["simulate, write and segment them"] == 2777.8
    assert values["tables on disk"] == 20
    assert values["memory of every training process"] == 500
    epochs = load_params(ROOT / "params.yaml").train_predictor.training.epochs
    assert values[f"its {epochs} epochs"] == pytest.approx(epochs * values[EPOCH], rel=1e-3)
    parts = [values[row[0]] for row in rows if "core-hours" in row[1] and row[0] != "total"]
    assert values["total"] == pytest.approx(sum(parts) - values[EPOCH], abs=0.3)
    cost = values[f"at {CORE_HOUR:.2f} EUR per core-hour"]
    assert cost == pytest.approx(CORE_HOUR * values["total"], abs=0.01)
