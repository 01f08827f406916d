"""Error of a predictor trained in 16-bit precision; minutes.

Trains the transformer in both precisions with three seeds, for fewer epochs than a full training,
and forecasts the test windows. Needs `dvc repro segment`; writes ``reports/costs/precision.csv``.
"""

import tempfile
from pathlib import Path

from rich.console import Console

from experiments.benchmarks.comparison import COSTS, ROOT
from rallygap.pipeline.io.artifacts import write_csv
from rallygap.pipeline.params import Params, load_params
from rallygap.pipeline.sweeps.predictor import compare_predictors
from rallygap.pipeline.sweeps.settings import PredictorSweep, Sweep

MEASURED = COSTS / "precision.csv"
EPOCHS = 8
PRECISIONS = ("32-true", "bf16-mixed")


def compared() -> list[Params]:
    """Return params.yaml with short trainings in both precisions."""
    params = load_params(ROOT / "params.yaml")
    short = []
    for precision in PRECISIONS:
        changes = {"precision": precision, "epochs": EPOCHS}
        training = params.train_predictor.training.model_copy(update=changes)
        settings = params.train_predictor.model_copy(update={"training": training})
        short.append(params.model_copy(update={"train_predictor": settings}))
    return short


def main() -> None:
    """Measure, write, print."""
    sweep = Sweep(ROOT, "predictor").settings
    assert isinstance(sweep, PredictorSweep)
    both = compared()
    with tempfile.TemporaryDirectory() as folder:
        table = compare_predictors(ROOT, sweep, both, Path(folder))
    table = table.rename(columns={"params": PRECISIONS[0], "found": PRECISIONS[1]})
    write_csv(MEASURED, table.drop(columns="holds"), digits=4)
    Console().print(MEASURED.read_text())


if __name__ == "__main__":
    main()
