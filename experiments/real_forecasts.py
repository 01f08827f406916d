"""Forecasts of measured sets: some recordings adapt predictors, which are tested on the others."""

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.predictors.evaluation import ForecastErrors, concat_tables, forecast_errors
from rallygap.models.predictors.learned import ForecastNetwork
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import ProbabilisticPredictor
from rallygap.models.predictors.settings import TrainingSettings
from rallygap.models.predictors.training import WindowData
from rallygap.models.predictors.transformer import Transformer
from rallygap.models.predictors.window_dataset import build_tracks
from rallygap.models.predictors.windows import Windows, concatenate_windows, cut_windows
from rallygap.pipeline.evaluation import coverage
from rallygap.pipeline.evaluation.forecasts import concatenated
from rallygap.pipeline.gap.shots import shots_of, source_shots
from rallygap.pipeline.io.episodes import MeasuredEpisode
from rallygap.pipeline.params import EvaluatePredictorSettings
from rallygap.pipeline.predictors.parallel_training import TrainingJob

HYBRID, TRANSFORMER, OTHER = "hybrid", "transformer", "transformer_2"


def amended_by(episodes: Sequence[MeasuredEpisode], nominal: Simulator) -> Simulator:
    """Return a simulator as the shots among some episodes amend it."""
    shots = source_shots(episodes)
    return amended(nominal, diagnose(shots_of(shots.members), nominal, nets=shots.nets))


class FineTuning(NamedTuple):
    """Networks that were trained on the arena, and how they are fine-tuned to recordings."""

    transformer: ForecastNetwork
    hybrid: ForecastNetwork
    settings: TrainingSettings
    seed: int

    def jobs(self, fold: "Fold", physics: PhysicsPredictor, folder: Path) -> Iterator[TrainingJob]:
        """Yield the trainings: of a hybrid that corrects a predictor, and two transformers.

        The second transformer sees other draws of windows. It is what an ensemble of a transformer
        and the hybrid is compared with.

        Args:
            fold: whose other episodes they learn from.
            physics: with the simulator that these amend.
            folder: of checkpoints.
        """
        tracks = build_tracks([member.episode for member in fold.others if member.unbroken])
        # Nothing is chosen by validation, so there is none of its own.
        data, other = (
            WindowData(tracks, tracks, self.settings, seed) for seed in (self.seed, self.seed + 1)
        )
        jobs = {
            HYBRID: (_correcting(self.hybrid, physics, data), data),
            TRANSFORMER: (copy.deepcopy(self.transformer), data),
            OTHER: (copy.deepcopy(self.transformer), other),
        }
        for key, (network, own) in jobs.items():
            yield TrainingJob(f"{key}-{fold.name}", network, own, folder / f"{key}-{fold.name}")


def _correcting(
    hybrid: ForecastNetwork, physics: PhysicsPredictor, data: WindowData
) -> ForecastNetwork:
    """Return a hybrid that says that another predictor is right, until it learns otherwise."""
    network = copy.deepcopy(hybrid)
    network.physics = physics
    assert isinstance(network.network, Transformer)
    network.network.start_at_baseline()
    data.fit_outputs(network)  # what this predictor leaves may be larger
    return network


class Fold(NamedTuple):
    """The episodes of one part of a set's recordings, and the others, which adapt predictors."""

    name: str
    tested: list[MeasuredEpisode]
    others: list[MeasuredEpisode]


@dataclass(frozen=True)
class Tested:
    """The test windows of all folds of a set, with predictors that know the other folds.

    Attributes:
        windows: of each fold.
        recordings: (B,) of each window, fold after fold.
        predictors: of each fold, by name.
    """

    windows: list[Windows]
    recordings: NDArray[Any]
    predictors: list[Mapping[str, ProbabilisticPredictor]]

    @classmethod
    def of(
        cls,
        folds: list[Fold],
        adapted: Mapping[str, Mapping[str, ProbabilisticPredictor]],
        every: float,
    ) -> "Tested":
        """Cut the unbroken test episodes into windows, ``every`` so many s."""
        members = [[member for member in fold.tested if member.unbroken] for fold in folds]
        parts = [[cut_windows(member.episode, every) for member in group] for group in members]
        recordings = [
            np.repeat(member.recording_id, len(part))
            for group, cut in zip(members, parts, strict=True)
            for member, part in zip(group, cut, strict=True)
        ]
        return cls(
            [concatenate_windows(cut) for cut in parts],
            np.concatenate(recordings),
            [adapted[fold.name] for fold in folds],
        )

    def errors(self, settings: EvaluatePredictorSettings, seed: int) -> ForecastErrors:
        """Return the errors of all predictors."""
        whole = concatenate_windows(self.windows)
        forecasts = {
            name: concatenated(
                [predictor.predict(part.history) for predictor, part in self._with(name)]
            )
            for name in self.predictors[0]
        }
        return ForecastErrors(
            forecast_errors(forecasts, whole),
            self.recordings,
            whole.bounced[:, -1],
            settings.bootstrap_resamples,
            seed,
        )

    def coverage(self, settings: EvaluatePredictorSettings, seed: int) -> pd.DataFrame:
        """Return the coverage of regions; the other folds' errors calibrate those of a fold."""
        tables = {}
        for name in self.predictors[0]:
            parts = [coverage.errors_of(predictor, part) for predictor, part in self._with(name)]
            result = coverage.Coverage.crossed(parts)
            resamples = settings.bootstrap_resamples
            tables[(name,)] = result.table(self.recordings, resamples, seed)
        return concat_tables(tables, ["predictor"])

    def _with(self, name: str) -> Iterator[tuple[ProbabilisticPredictor, Windows]]:
        """Yield the predictor of each fold and the fold's windows."""
        for predictors, part in zip(self.predictors, self.windows, strict=True):
            yield predictors[name], part
