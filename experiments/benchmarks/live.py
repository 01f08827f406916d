"""Latency of live forecasts (`python -m experiments.benchmarks.live`; minutes).

Replays recordings of the last run through forecasters, one predictor after the other on one core. A
frame is answered when its measurement is filtered and the ball is forecast at the horizons of a
policy, with covariances. The predictor's own call on windows is measured in the same run.
The paper's size of the transformer has random weights, which take as long as trained ones. Needs
`dvc repro evaluate_predictor`; writes ``reports/live``.
"""

import time
from collections.abc import Sequence
from itertools import islice

import numpy as np
import torch
from rich.console import Console

from experiments.benchmarks.comparison import ROOT, machine, one_core
from rallygap.models.live.compiled import CompiledPredictor
from rallygap.models.live.forecaster import Forecaster
from rallygap.models.live.track import history_of
from rallygap.models.predictors.learned import LearnedPredictor, build_network
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import FUTURE_TIMES, Floats, ProbabilisticPredictor
from rallygap.models.predictors.settings import TransformerSettings
from rallygap.models.predictors.spread import Spread
from rallygap.pipeline.evaluation.predictors import ARENA, ORACLE, read_predictors
from rallygap.pipeline.io.artifacts import read_table, write_json
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.live.messages import Measurement, measurements
from rallygap.pipeline.params import load_params, read_yaml
from rallygap.pipeline.runtime.progress import progress

FRAMES = 20_000
AHEAD = np.array([0.115, 0.12, 0.125])  # s, the horizons of a policy
WARM_UP = 200  # frames
EVERY = 20  # frames between two calls of the predictor itself
PAPER = "transformer_paper_size"
REPORT = ROOT / "reports" / "live" / "latency.json"


def measure(
    predictor: ProbabilisticPredictor, rows: Sequence[Measurement]
) -> dict[str, float | None]:
    """Return the latency of a predictor; simulators forecast from all measurements of a ball.

    Returns:
        Median and 99th percentile of a frame; the median of the predictor's own call, ``eager_ms``;
        and the largest distance between the live forecast and that of this call.
    """
    if isinstance(predictor, PhysicsPredictor):
        forecaster = Forecaster(predictor.simulator)
    else:
        assert isinstance(predictor, LearnedPredictor)
        compiled = CompiledPredictor(predictor, (AHEAD[0], AHEAD[-1]))
        forecaster = Forecaster(load_simulator("literature"), compiled)
    for row in rows[:WARM_UP]:
        _answer(forecaster, row)
    taken = []
    for row in rows:
        start = time.perf_counter()
        _answer(forecaster, row)
        taken.append(time.perf_counter() - start)
    eager, change = _compared(forecaster, predictor, rows)
    p50, p99 = np.percentile(taken, [50, 99])
    return {
        "p50_ms": _rounded(p50),
        "p99_ms": _rounded(p99),
        "eager_ms": _rounded(eager),
        "max_change_mm": _rounded(change) if forecaster.predictor else None,
    }


def _compared(
    forecaster: Forecaster, predictor: ProbabilisticPredictor, rows: Sequence[Measurement]
) -> tuple[float, float]:
    """Return the seconds of a predictor's own call, and its largest change in m by the forecaster.

    It is called at some frames only, and not while frames are timed: it would empty the caches.
    """
    eager, changes = [], [0.0]
    for number, row in enumerate(rows):
        states = _answer(forecaster, row)
        if states is not None and number % EVERY == 0:
            start = time.perf_counter()
            forecast, _ = predictor.predict_with_covariances(history_of(forecaster.ball))
            eager.append(time.perf_counter() - start)
            own = forecast.states[0]
            own = np.stack([np.interp(AHEAD, FUTURE_TIMES, own[:, k]) for k in range(3)], axis=1)
            changes.append(float(np.linalg.norm(states[:, :3] - own, axis=1).max()))
    return float(np.median(eager)), max(changes)


def _paper_size(trained: LearnedPredictor) -> LearnedPredictor:
    """Return the transformer of the paper's size with the normaliser of the laptop's."""
    paper = read_yaml(ROOT / "experiments" / "profiles" / "paper_network.yaml")
    described = paper["train_predictor"]["networks"]["transformer"]
    settings = TransformerSettings(kind="transformer", **described)
    torch.manual_seed(0)
    network = build_network(settings)
    network.normaliser = trained.network.normaliser
    return LearnedPredictor(network, Spread())


def _answer(forecaster: Forecaster, row: Measurement) -> Floats | None:
    assert row.position is not None  # recordings have balls only
    forecaster.observe(row.time, row.position, spin=row.spin)
    return forecaster.predict(forecaster.last + AHEAD)[0] if forecaster.ready else None


def _rounded(thousandths: float) -> float:
    """Return ms or mm to three digits, of s or m."""
    return round(1e3 * float(thousandths), 3)


def main() -> None:
    """Measure, write, print."""
    settings = load_params(ROOT / "params.yaml").evaluate_predictor
    recorded = read_table(ROOT / "artifacts" / "ingest" / "recordings.parquet")
    rows = list(islice(measurements([recorded]), FRAMES))
    assert len(rows) == FRAMES, "ingest more"
    predictors = {
        named.name: named.predictor
        for named in read_predictors(ROOT / "artifacts", settings)
        if named.forecasts(ARENA) and named.kind not in ("physics", ORACLE)
    }
    trained = predictors["transformer"]
    assert isinstance(trained, LearnedPredictor)
    predictors[PAPER] = _paper_size(trained)
    with one_core():
        measured = {
            name: measure(predictor, rows)
            for name, predictor in progress(predictors.items(), "latency", len(predictors))
        }
    write_json(REPORT, measured)
    write_json(REPORT.with_name("machine.json"), machine())
    Console().print(measured)


if __name__ == "__main__":
    main()
