"""Forecasts of all test windows by all predictors, their errors, and forecasts to be shown."""

from collections.abc import Sequence
from functools import partial
from itertools import zip_longest

import numpy as np

from rallygap.models.predictors.evaluation import ForecastErrors, forecast_errors
from rallygap.models.predictors.protocol import FUTURE_TIMES, Forecast
from rallygap.models.predictors.windows import Windows, cut_windows
from rallygap.pipeline.evaluation.evaluation_windows import MeasuredSet
from rallygap.pipeline.evaluation.example_shots import MOST_SHOTS, Point, Shot
from rallygap.pipeline.evaluation.example_shots import Forecast as ShownForecast
from rallygap.pipeline.evaluation.predictors import NamedPredictor
from rallygap.pipeline.io.episodes import MeasuredEpisode
from rallygap.pipeline.params import EvaluatePredictorSettings
from rallygap.pipeline.runtime.parallel import parallel

BATCH = 256  # windows
SMALLEST = 1e-4  # m, that an error counts as at least


def forecast_windows(
    measured: MeasuredSet, predictors: Sequence[NamedPredictor]
) -> dict[str, Forecast]:
    """Return each predictor's forecast of all windows of a set, computed in parallel."""
    history = measured.windows.history
    starts = range(0, len(history), BATCH)
    tasks = [
        partial(named.predictor.predict, history[start : start + BATCH])
        for named in predictors
        for start in starts
    ]
    batches = list(parallel(tasks, f"forecasts on {measured.name}"))
    return {
        predictor.name: concatenated(batches[k * len(starts) : (k + 1) * len(starts)])
        for k, predictor in enumerate(predictors)
    }


def evaluate(
    forecasts: dict[str, Forecast],
    windows: Windows,
    measured: MeasuredSet,
    settings: EvaluatePredictorSettings,
    seed: int,
) -> ForecastErrors:
    """Return the errors of forecasts.

    Args:
        forecasts: of the set's windows, by predictor.
        windows: the set's, with the measured or the true future.
        measured: the set.
        settings: of the stage.
        seed: of the bootstrap.
    """
    return ForecastErrors(
        forecast_errors(forecasts, windows),
        measured.recordings,
        measured.windows.bounced[:, -1],
        settings.bootstrap_resamples,
        seed,
    )


def concatenated(batches: Sequence[Forecast]) -> Forecast:
    """Return the forecasts of several batches as one."""
    return Forecast(
        np.concatenate([batch.states for batch in batches]),
        np.concatenate([batch.spin_measured for batch in batches]),
    )


def draw_shots(
    sets: Sequence[MeasuredSet], predictors: Sequence[NamedPredictor], seed: int
) -> list[Shot]:
    """Draw test episodes, alternating between sets, and forecast each from its first window.

    Of those of a set, the first one has the most typical errors.
    """
    generator = np.random.default_rng(seed)
    drawn = []
    for measured in sets:
        cuts = [(episode, cut_windows(episode.episode, every=1.0)) for episode in measured.episodes]
        usable = [(episode, cut) for episode, cut in cuts if len(cut)]
        pairs = [usable[k] for k in generator.permutation(len(usable))[:MOST_SHOTS]]
        shown = [(_shot(episode, cut, predictors), cut) for episode, cut in pairs]
        drawn.append(typical_first([shot for shot, _ in shown], [cut for _, cut in shown]))
    turns = [shot for turn in zip_longest(*drawn) for shot in turn if shot is not None]
    return turns[:MOST_SHOTS]


def typical_first(shots: Sequence[Shot], cuts: Sequence[Windows]) -> list[Shot]:
    """Return shots of a set with the one first whose errors are nearest to the median.

    Distances are of the logarithms of errors, summed over predictors.

    Args:
        shots: with the forecasts of the same predictors.
        cuts: the window that each is forecast from.
    """
    if not shots:
        return []
    errors = np.log([_last_errors(*pair) for pair in zip(shots, cuts, strict=True)])
    away = np.abs(errors - np.median(errors, axis=0)).sum(axis=1)
    first = int(away.argmin())
    return [shots[first], *shots[:first], *shots[first + 1 :]]


def _last_errors(shot: Shot, cut: Windows) -> list[float]:
    """Return the error of each predictor at the last measured state of the first window."""
    last = int(np.flatnonzero(cut.measured[0, :, 0])[-1])
    true = cut.future[0, last, :3]
    away = [np.linalg.norm(forecast.position[last] - true) for forecast in shot.forecasts.values()]
    return [max(float(size), SMALLEST) for size in away]


def _shot(measured: MeasuredEpisode, cut: Windows, predictors: Sequence[NamedPredictor]) -> Shot:
    good = ~measured.episode.outlier
    anchor = float(cut.anchors[0])
    times = [round(anchor + time, 6) for time in FUTURE_TIMES]
    forecasts = {
        named.name: ShownForecast(
            t=times, position=_points(named.predictor.predict(cut.history).states[0, :, :3])
        )
        for named in predictors
        if named.forecasts(measured.source)
    }
    return Shot(
        episode_id=measured.episode_id,
        source=measured.source,
        t=measured.episode.times[good].tolist(),
        measured=_points(measured.episode.positions[good]),
        anchor=anchor,
        forecasts=forecasts,
    )


def _points(positions: np.ndarray) -> list[Point]:
    return [(x, y, z) for x, y, z in np.round(positions, 5).tolist()]
