"""Predictors as they are and as a sweep found them, on test windows."""

from pathlib import Path

import numpy as np
from joblib import Parallel, cpu_count, delayed
from numpy.typing import NDArray

from models.predictors.errors import HORIZONS_MS, errors
from models.predictors.evaluation import SHOWN_HORIZONS_MS
from models.predictors.learned import LearnedPredictor
from models.predictors.protocol import Forecast
from models.predictors.windows import Windows
from pipeline.evaluation.contenders import one_thread
from pipeline.evaluation.test_windows import MeasuredSet, read_test_sets
from pipeline.params import Params
from pipeline.sweeps.paired_comparison import SEEDS, Judged, repeat_seed
from pipeline.sweeps.predictor_trial import PredictorTrials
from pipeline.sweeps.settings import PredictorSweep

Floats = NDArray[np.float64]

# The quantities that are judged.
UNITS = {"position": "mm", "velocity": "m/s", "spin": "rad/s"}
WINDOWS_AT_ONCE = 256


def judged_predictors(
    root: Path, sweep: PredictorSweep, both: list[Params], folder: Path
) -> Judged:
    """Train the network with both parameters and every seed; forecast the test windows.

    Args:
        root: of the repository, with the artefacts of ingest and segment.
        sweep: which network.
        both: the parameters as they are, and those found.
        folder: for checkpoints.
    """
    trials = PredictorTrials(root, sweep, both[0])
    sets = _test_sets(root, both[0])
    jobs = [
        (params.model_copy(update={"seed": repeat_seed(params.seed, k + 1)}), f"{name}-{k}")
        for name, params in zip(("params", "found"), both, strict=True)
        for k in range(SEEDS)
    ]
    # Without memory maps, which torch warns of because it could not write to them.
    parallel = Parallel(min(cpu_count(), len(jobs)), max_nbytes=None)
    measured: list[Floats] = parallel(
        delayed(_measured)(trials, params, folder / name, sets) for params, name in jobs
    )
    recordings = np.concatenate([one.recordings for one in sets])
    return Judged(
        _measures(),
        smaller_is_better=True,
        params=np.stack(measured[:SEEDS]),
        found=np.stack(measured[SEEDS:]),
        groups=np.tile(recordings, (SEEDS, 1)),
    )


def _test_sets(root: Path, params: Params) -> list[MeasuredSet]:
    every = params.evaluate_predictor.window_every_ms / 1000
    sets = read_test_sets(root / "artifacts", every)
    return [one for one in sets if one.name in params.train_predictor.sources]


@one_thread()
def _measured(
    trials: PredictorTrials, params: Params, folder: Path, sets: list[MeasuredSet]
) -> Floats:
    """Return (N, K) errors of a predictor that is trained for them."""
    predictor = LearnedPredictor(trials.trained(params, folder).network)
    return np.concatenate([_errors(predictor, one.windows) for one in sets])


def _errors(predictor: LearnedPredictor, windows: Windows) -> Floats:
    """Return the (N, K) errors of a predictor on N windows, by ``_measures``."""
    history = windows.history
    starts = range(0, len(history), WINDOWS_AT_ONCE)
    parts = [predictor.predict(history[start : start + WINDOWS_AT_ONCE]) for start in starts]
    forecast = Forecast(
        np.concatenate([part.states for part in parts]),
        np.concatenate([part.spin_measured for part in parts]),
    )
    by_quantity = [errors(forecast, windows, quantity) for quantity in UNITS]
    shown = [HORIZONS_MS.index(horizon) for horizon in SHOWN_HORIZONS_MS]
    columns = [_over_horizons(by_quantity[0]), *(one[:, shown] for one in by_quantity)]
    return np.column_stack(columns)


def _over_horizons(error: Floats) -> Floats:
    """Return (N,) means of (N, H) errors over the horizons that were measured; NaN without any."""
    counted = np.isfinite(error)
    with np.errstate(invalid="ignore"):
        mean: Floats = np.where(counted, error, 0.0).sum(axis=1) / counted.sum(axis=1)
    return mean


def _measures() -> list[str]:
    """Return what the columns of ``_errors`` are."""
    shown = [
        f"{quantity} error at {horizon} ms ({unit})"
        for quantity, unit in UNITS.items()
        for horizon in SHOWN_HORIZONS_MS
    ]
    return [f"position error, {HORIZONS_MS[0]} to {HORIZONS_MS[-1]} ms (mm)", *shown]
