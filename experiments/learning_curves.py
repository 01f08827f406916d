"""Learning curves: how good predictors are by the number of recordings that they learn from."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.predictors.protocol import Floats
from rallygap.models.predictors.training import WindowData
from rallygap.models.support.clustered_means import clustered_mean
from rallygap.pipeline.evaluation.predictors import ORACLE
from rallygap.pipeline.gap.cases import cases
from rallygap.pipeline.gap.shots import source_shots
from rallygap.pipeline.io.episodes import MeasuredEpisode, read_episodes
from rallygap.pipeline.io.source_manifest import read_manifest
from rallygap.pipeline.params import Params
from rallygap.pipeline.predictors.parallel_training import TrainingJob
from rallygap.pipeline.predictors.training_data import TRAIN, TrainingEpisodes, untrained_network


@dataclass(frozen=True)
class Subset:
    """The first training recordings of a random order: how many, the order's number, and which."""

    size: int
    draw: int
    recordings: frozenset[str]

    @property
    def name(self) -> str:
        """Of files and trainings."""
        return f"{self.size}-{self.draw}"


def subsets(
    recordings: Collection[str], sizes: Sequence[int], draws: int, seed: int
) -> Iterator[Subset]:
    """Yield subsets of each size below the number of recordings, and all of them.

    In a draw, the larger ones contain the smaller ones.
    """
    names = sorted(recordings)
    for draw in range(draws):
        order = np.random.default_rng([seed, draw]).permutation(len(names))
        for size in [*(size for size in sizes if size < len(names)), len(names)]:
            yield Subset(size, draw, frozenset(names[k] for k in order[:size]))


class Learner:
    """Learns from subsets of the training recordings of one source.

    Args:
        artifacts: the folder of all stages' artefacts.
        source: of the recordings.
        params: settings of the stages that learn.
    """

    def __init__(self, artifacts: Path, source: str, params: Params) -> None:
        self.artifacts, self.source, self.params = artifacts, source, params

    @cached_property
    def _episodes(self) -> TrainingEpisodes:
        return TrainingEpisodes(self.artifacts, self.params.seed)

    @cached_property
    def _whole(self) -> WindowData:
        """Of all recordings."""
        return self._episodes.window_data([self.source], self.params.train_predictor.training)

    @cached_property
    def members(self) -> list[MeasuredEpisode]:
        """Training episodes of the source, those that are no shots as well."""
        manifest = read_manifest(self.artifacts / "ingest" / "manifest.json")
        episodes = read_episodes(self.artifacts / "segment", manifest.labelled_once, (TRAIN,))
        return [episode for episode in episodes if episode.source == self.source]

    @property
    def recordings(self) -> frozenset[str]:
        """The training recordings."""
        return frozenset(member.recording_id for member in self.members)

    def amended(self, subset: Subset, name: str) -> Simulator:
        """Return a simulator of ``close_gap`` as a subset amends it; too few shots leave it."""
        members = [member for member in self.members if member.recording_id in subset.recordings]
        settings, seed = self.params.close_gap, self.params.seed + subset.draw
        all_cases = cases({self.source: source_shots(members)}, settings, seed)
        case = next(case for case in all_cases if case.simulator_name == name)
        if len(case.shots) < DEFAULTS.verify.held_out:
            return case.simulator
        return amended(case.simulator, case.diagnose().verdict)

    def training(self, subset: Subset, network: str, folder: Path) -> TrainingJob:
        """Return the training of a network: as many windows as with all recordings.

        Weights and draws of windows differ between draws.
        """
        known = self._whole
        data = self._episodes.window_data([self.source], known.settings, subset.recordings)
        data.seed = self.params.seed + subset.draw
        windows = known.settings.windows_per_episode * known.train.episodes
        per_episode = max(round(windows / data.train.episodes), 1)
        data.settings = known.settings.model_copy(update={"windows_per_episode": per_episode})
        untrained = untrained_network(self.params.train_predictor.networks[network], data)
        return TrainingJob(f"{network}-{subset.name}", untrained, data, folder)


@dataclass(frozen=True)
class Errors:
    """Position errors of predictors of D draws on the same B windows.

    Attributes:
        predictor: what kind of predictor.
        recordings: that each has learned from.
        by_draw: (D, B, H) m, NaN where nothing was measured.
    """

    predictor: str
    recordings: int
    by_draw: Floats


def curve_rows(errors: list[Errors], tested: np.ndarray, horizons_ms: list[int]) -> pd.DataFrame:
    """Return one row a predictor, number of recordings and horizon.

    Means, in mm, are over draws and windows, their 95 % intervals over draws and test
    recordings.
    ``of_oracle`` is the mean divided by that of the oracle, ``median`` that of all windows and
    draws.

    Args:
        errors: the oracle's among them.
        tested: (B,) the test recording of each window.
        horizons_ms: of the errors.
    """
    oracle = next(kind.by_draw for kind in errors if kind.predictor == ORACLE)
    best, rows = np.nanmean(oracle, axis=(0, 1)), []
    for kind in errors:
        means, medians = (
            clustered_mean(kind.by_draw, tested),
            np.nanmedian(kind.by_draw, axis=(0, 1)),
        )
        columns = {
            "horizon_ms": horizons_ms,
            "mean": 1e3 * means.mean,
            "ci_low": 1e3 * means.low,
            "ci_high": 1e3 * means.high,
            "median": 1e3 * medians,
            "of_oracle": means.mean / best,
            "draws": len(kind.by_draw),
            "n": np.isfinite(kind.by_draw[0]).sum(axis=0),
        }
        keys = {"predictor": kind.predictor, "recordings": kind.recordings}
        rows.append(pd.DataFrame({**keys, **columns}))
    return pd.concat(rows, ignore_index=True)
