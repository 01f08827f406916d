"""Error of a predictor trained in 16-bit precision (`python -m benchmarks.precision`; minutes).

Trains the transformer in both precisions with three seeds, for fewer epochs than a full training,
and forecasts the test windows. Needs `dvc repro segment`; writes ``reports/costs/precision.csv``.
"""

import tempfile
from pathlib import Path

import pandas as pd
from rich.console import Console

from benchmarks.comparison import ROOT
from rallygap.pipeline.io.artifacts import write_csv
from rallygap.pipeline.params import Params, load_params
from rallygap.pipeline.sweeps.predictor import compare_predictors
from rallygap.pipeline.sweeps.settings import PredictorSweep, load_sweep

MEASURED = ROOT / "reports" / "costs" / "precision.csv"
EPOCHS = 8
PRECISIONS = ("32-true", "bf16-mixed")


def compared() -> list[Params]:
    """Return params.yaml with short trainings in both precisions."""
    params = load_params(ROOT / "params.yaml")
    settings = params.train_predictor
    trainings = [
        settings.training.model_copy(update={"precision": precision, "epochs": EPOCHS})
        for precision in PRECISIONS
    ]
    return [
        params.model_copy(update={"train_predictor": settings.model_copy(update={"training": one})})
        for one in trainings
    ]


def measure() -> pd.DataFrame:
    """Return the table of ``Comparison``; `params` are 32 bits, `found` 16."""
    sweep = load_sweep(ROOT, "predictor").settings
    assert isinstance(sweep, PredictorSweep)
    both = compared()
    with tempfile.TemporaryDirectory() as folder:
        return compare_predictors(ROOT, sweep, both, Path(folder)).table(both[0].seed)


def main() -> None:
    """Measure, write, print."""
    table = measure().rename(columns={"params": PRECISIONS[0], "found": PRECISIONS[1]})
    write_csv(MEASURED, table.drop(columns="holds"), digits=4)
    Console().print(MEASURED.read_text())


if __name__ == "__main__":
    main()
