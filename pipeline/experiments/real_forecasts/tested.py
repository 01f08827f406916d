"""Tests of adapted predictors: each recording once, by predictors that do not know it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rallygap.models.predictors.evaluation import ForecastErrors, concat_tables, forecast_errors
from rallygap.models.predictors.protocol import ProbabilisticPredictor
from rallygap.models.predictors.windows import Windows, concatenate_windows, cut_windows
from rallygap.pipeline.evaluation import coverage
from rallygap.pipeline.evaluation.forecasts import concatenated
from rallygap.pipeline.io.episodes import MeasuredEpisode
from rallygap.pipeline.params import EvaluatePredictorSettings


@dataclass(frozen=True)
class Fold:
    """One part of the recordings of a set, which the others adapt predictors for.

    Attributes:
        name: of its files.
        tested: its episodes.
        others: those of the other folds.
    """

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
        members = [[one for one in fold.tested if one.unbroken] for fold in folds]
        parts = [[cut_windows(one.episode, every) for one in some] for some in members]
        recordings = [
            np.repeat(one.recording_id, len(part))
            for some, cut in zip(members, parts, strict=True)
            for one, part in zip(some, cut, strict=True)
        ]
        return cls(
            [concatenate_windows(cut) for cut in parts],
            np.concatenate(recordings),
            [adapted[fold.name] for fold in folds],
        )

    @property
    def names(self) -> list[str]:
        """Of the predictors."""
        return list(self.predictors[0])

    def errors(self, settings: EvaluatePredictorSettings, seed: int) -> ForecastErrors:
        """Return the errors of all predictors."""
        whole = concatenate_windows(self.windows)
        forecasts = {
            name: concatenated([one.predict(part.history) for one, part in self._with(name)])
            for name in self.names
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
        for name in self.names:
            parts = [coverage.errors_of(one, part) for one, part in self._with(name)]
            found = coverage.Coverage.crossed(parts)
            resamples = settings.bootstrap_resamples
            tables[(name,)] = found.table(self.recordings, resamples, seed)
        return concat_tables(tables, ["predictor"])

    def _with(self, name: str) -> Iterator[tuple[ProbabilisticPredictor, Windows]]:
        """Yield the predictor of each fold and the fold's windows."""
        for some, part in zip(self.predictors, self.windows, strict=True):
            yield some[name], part
