"""Evaluate the predictors: forecast error over the horizon, on every set of measured balls."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np
import pandas as pd

from models.predictors.errors import HORIZONS_MS, QUANTITIES, errors, spread
from models.predictors.physics import PhysicsPredictor
from models.predictors.protocol import FUTURE_TIMES, Forecast, Predictor
from models.predictors.windows import Windows, joined, windows
from pipeline.console import warn
from pipeline.episodes import MeasuredEpisode, read_episodes
from pipeline.errors import InputError
from pipeline.figures.forecast_error import forecast_error_figure
from pipeline.figures.shots import MOST_SHOTS, Shot, write_shots
from pipeline.figures.shots import Forecast as ShownForecast
from pipeline.params import EvaluatePredictorSettings
from pipeline.progress import progress
from pipeline.run import StageRun, run_stage
from pipeline.simulators import load_simulator
from pipeline.sources.manifest import SourceRecord, read_manifest

SHOWN_HORIZONS_MS = (100, 200, 300)
WINDOWS_AT_ONCE = 256


@dataclass(frozen=True)
class MeasuredSet:
    """The windows of one source, the recording of each, and the episodes they were cut from."""

    source: SourceRecord
    windows: Windows
    recordings: np.ndarray
    episodes: list[MeasuredEpisode]

    @property
    def name(self) -> str:
        """The source's name."""
        return self.source.name


def evaluate_predictor(run: StageRun) -> None:
    """Forecast every window with every predictor and report how far the forecasts are off."""
    settings = run.params.evaluate_predictor
    predictors = build_predictors(settings)
    sets = list(_measured_sets(run, settings.window_every_ms / 1000))
    forecasts = {
        one.name: {name: _forecast(one, name, predictor) for name, predictor in predictors.items()}
        for one in sets
    }
    generator = np.random.default_rng(run.seed)
    rows = [
        row
        for one in sets
        for name, forecast in forecasts[one.name].items()
        for row in _rows(one, name, forecast, settings.bootstrap_resamples, generator)
    ]
    if not rows:
        problem = (
            "no unbroken episode has a window to evaluate: 155 ms with samples at most 15 ms "
            "apart; are its sources in seconds and metres?"
        )
        raise InputError(run.input("segment", "episodes.parquet"), problem)
    frame = pd.DataFrame(rows)
    run.write_metrics(_metrics(frame))
    _report(run, sets, frame)
    write_shots(run.artifact("shots.json"), _shots(sets, predictors, run.seed))


def build_predictors(settings: EvaluatePredictorSettings) -> dict[str, Predictor]:
    """Return the predictors that the parameters name."""
    return {
        name: PhysicsPredictor(load_simulator(predictor.simulator))
        for name, predictor in settings.predictors.items()
    }


def _measured_sets(run: StageRun, every: float) -> Iterator[MeasuredSet]:
    """Cut the unbroken episodes of every source into windows; a source without any is left out."""
    manifest = read_manifest(run.input("ingest", "manifest.json"))
    once = {name for name, source in manifest.sources.items() if source.spin == "per_recording"}
    episodes = read_episodes(run.input("segment", ""), once)
    for name in sorted({episode.source for episode in episodes}):
        members = [one for one in episodes if one.source == name and one.unbroken]
        cut = [windows(one.episode, every) for one in members]
        recordings = [
            one.recording_id
            for one, part in zip(members, cut, strict=True)
            for _ in range(len(part))
        ]
        if not recordings:
            warn(f"{name} has no window to evaluate: 155 ms with samples at most 15 ms apart")
            continue
        yield MeasuredSet(manifest.sources[name], joined(cut), np.array(recordings), members)
        run.log_input(name, run.input("segment", "samples.parquet"), len(recordings))


def _forecast(one: MeasuredSet, name: str, predictor: Predictor) -> Forecast:
    history = one.windows.history
    starts = progress(range(0, len(history), WINDOWS_AT_ONCE), f"{name} on {one.name}")
    parts = [predictor.predict(history[start : start + WINDOWS_AT_ONCE]) for start in starts]
    return Forecast(
        np.concatenate([part.states for part in parts]),
        np.concatenate([part.spin_measured for part in parts]),
    )


def _rows(
    one: MeasuredSet,
    predictor: str,
    forecast: Forecast,
    resamples: int,
    generator: np.random.Generator,
) -> Iterator[dict[str, object]]:
    """Yield one row a quantity, kind of window and horizon."""
    with_bounce = one.windows.bounced[:, -1]
    kinds = {
        "all": np.ones(len(with_bounce), dtype=bool),
        "with": with_bounce,
        "without": ~with_bounce,
    }
    for quantity in QUANTITIES:
        error = errors(forecast, one.windows, quantity)
        for kind, chosen in kinds.items():
            result = spread(error[chosen], one.recordings[chosen], resamples, generator)
            for k in np.flatnonzero(result.count):
                yield {
                    "set": one.name,
                    "predictor": predictor,
                    "quantity": quantity,
                    "bounce": kind,
                    "horizon_ms": HORIZONS_MS[k],
                    "mean": result.mean[k],
                    "std": result.std[k],
                    "n": int(result.count[k]),
                    "ci_low": result.low[k],
                    "ci_high": result.high[k],
                }


def _metrics(frame: pd.DataFrame) -> dict[str, object]:
    """Return ``{set: {predictor: {quantity: {horizon_ms: {mean, std, n}}}}}`` over all windows."""
    metrics: dict[str, object] = {}
    keys = ["set", "predictor", "quantity", "horizon_ms"]
    for row in frame[frame["bounce"] == "all"].to_dict("records"):
        place = metrics
        for key in keys:
            place = place.setdefault(str(row[key]), {})  # type: ignore[assignment]
        place.update(mean=_rounded(row["mean"]), std=_rounded(row["std"]), n=row["n"])
    return metrics


def _rounded(value: float) -> float:
    """Six digits: more would only show the processor's last bits."""
    return float(f"{value:.6g}")


def _report(run: StageRun, sets: list[MeasuredSet], frame: pd.DataFrame) -> None:
    for one in sets:
        run.add_figure(
            forecast_error_figure(frame[frame["set"] == one.name]),
            f"forecast_error_{one.name}",
            title=f"Forecast error on {one.name}",
            caption=_caption(one),
        )
    shown = frame[frame["horizon_ms"].isin(SHOWN_HORIZONS_MS)]
    run.add_table(
        shown,
        "forecast_error",
        title="Forecast error at 100, 200 and 300 ms",
        caption="Position in mm, velocity in m/s, spin in rad/s; n windows.",
    )


def _caption(one: MeasuredSet) -> str:
    caption = (
        "Distance between forecast and measured state over the horizon: mean over the windows "
        "(line), its 95 % interval bootstrapped over recordings (band), standard deviation "
        "(dotted). A window counts as with a bounce where the ball meets the table within 300 ms. "
        f"{one.source.note}"
    )
    if one.source.spin == "per_recording":
        caption += (
            " A shot has one spin label, which holds until the ball first touches something or is "
            "lost from sight: the spin error shows only forecasts of a bounce that came later or "
            "not at all."
        )
    return caption


def _shots(sets: list[MeasuredSet], predictors: dict[str, Predictor], seed: int) -> list[Shot]:
    """Draw episodes, the sets taking turns, and forecast each from its first window."""
    generator = np.random.default_rng(seed)
    drawn = []
    for one in sets:
        cuts = [(episode, windows(episode.episode, every=1.0)) for episode in one.episodes]
        usable = [(episode, cut) for episode, cut in cuts if len(cut)]
        drawn.append([usable[k] for k in generator.permutation(len(usable))])
    turns = [shot for turn in zip_longest(*drawn) for shot in turn if shot is not None]
    return [_shot(episode, cut, predictors) for episode, cut in turns[:MOST_SHOTS]]


def _shot(measured: MeasuredEpisode, cut: Windows, predictors: dict[str, Predictor]) -> Shot:
    good = ~measured.episode.outlier
    anchor = float(cut.anchors[0])
    ahead = [round(anchor + time, 6) for time in FUTURE_TIMES]
    forecasts = {
        name: ShownForecast(
            t=ahead, position=_points(predictor.predict(cut.history).states[0, :, :3])
        )
        for name, predictor in predictors.items()
    }
    return Shot(
        episode_id=measured.episode_id,
        source=measured.source,
        t=measured.episode.times[good].tolist(),
        measured=_points(measured.episode.positions[good]),
        anchor=anchor,
        forecasts=forecasts,
    )


def _points(positions: np.ndarray) -> list[tuple[float, float, float]]:
    return [(x, y, z) for x, y, z in np.round(positions, 5).tolist()]


if __name__ == "__main__":
    run_stage(evaluate_predictor)
