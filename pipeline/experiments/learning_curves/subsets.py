"""Subsets of the training recordings, and what is learned from them."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.predictors.training import WindowData
from rallygap.pipeline.gap.cases import cases
from rallygap.pipeline.gap.shots import source_shots
from rallygap.pipeline.io.episodes import MeasuredEpisode, read_episodes
from rallygap.pipeline.io.source_manifest import read_manifest
from rallygap.pipeline.params import Params
from rallygap.pipeline.predictors.parallel_training import TrainingJob
from rallygap.pipeline.predictors.training_data import TRAIN, TrainingEpisodes, untrained_network


@dataclass(frozen=True)
class Subset:
    """Some of the training recordings.

    Attributes:
        size: how many.
        draw: number of the random order of recordings whose first ones these are.
        recordings: these.
    """

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


@dataclass(frozen=True)
class Learner:
    """Learns from subsets of the training recordings of one source.

    Attributes:
        artifacts: the folder of all stages' artefacts.
        source: of the recordings.
        params: settings of the stages that learn.
    """

    artifacts: Path
    source: str
    params: Params

    @property
    def recordings(self) -> frozenset[str]:
        """The training recordings."""
        return frozenset(one.recording_id for one in self._members)

    def amended(self, subset: Subset, name: str) -> Simulator:
        """Return a simulator of ``close_gap`` as a subset amends it; too few shots leave it."""
        members = [one for one in self._members if one.recording_id in subset.recordings]
        settings, seed = self.params.close_gap, self.params.seed + subset.draw
        found = cases({self.source: source_shots(members)}, settings, seed)
        case = next(one for one in found if one.simulator_name == name)
        if len(case.shots) < DEFAULTS.verify.held_out:
            return case.simulator
        return amended(case.simulator, case.diagnose().verdict)

    def training(self, subset: Subset, network: str, folder: Path) -> TrainingJob:
        """Return the training of a network: as many windows as with all recordings.

        Weights and draws of windows differ between draws.
        """
        networks, known = self.params.train_predictor.networks, self._whole
        data = self._episodes.window_data([self.source], known.settings, subset.recordings)
        data.seed = self.params.seed + subset.draw
        windows = known.settings.windows_per_episode * known.train.episodes
        per_episode = max(round(windows / data.train.episodes), 1)
        data.settings = known.settings.model_copy(update={"windows_per_episode": per_episode})
        untrained = untrained_network(networks[network], data)
        return TrainingJob(f"{network}-{subset.name}", untrained, data, folder)

    @cached_property
    def _episodes(self) -> TrainingEpisodes:
        return TrainingEpisodes(self.artifacts, self.params.seed)

    @cached_property
    def _whole(self) -> WindowData:
        """Of all recordings."""
        return self._episodes.window_data([self.source], self.params.train_predictor.training)

    @cached_property
    def _members(self) -> list[MeasuredEpisode]:
        """Training episodes of the source, those that are no shots as well."""
        manifest = read_manifest(self.artifacts / "ingest" / "manifest.json")
        found = read_episodes(self.artifacts / "segment", manifest.labelled_once, (TRAIN,))
        return [one for one in found if one.source == self.source]
