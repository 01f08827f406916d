"""The measured episodes that networks are trained on, and untrained networks fitted to them."""

from collections.abc import Collection, Sequence
from pathlib import Path

import lightning

from rallygap.models.predictors.learned import ForecastNetwork, build_network
from rallygap.models.predictors.settings import HybridSettings, NetworkSettings, TrainingSettings
from rallygap.models.predictors.training import WindowData
from rallygap.models.predictors.window_dataset import build_tracks
from rallygap.pipeline.io.episodes import MeasuredEpisode, read_episodes
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.io.source_manifest import read_manifest
from rallygap.pipeline.runtime.errors import InputError

TRAIN = "train"
SPLITS = (TRAIN, "validation")


class TrainingEpisodes:
    """The unbroken training and validation episodes of all sources.

    Args:
        artifacts: the folder of all stages' artefacts.
        seed: of every draw.

    Raises:
        InputError: an artefact is missing or invalid.
    """

    def __init__(self, artifacts: Path, seed: int) -> None:
        self.seed, self.path = seed, artifacts / "segment" / "episodes.parquet"
        manifest = read_manifest(artifacts / "ingest" / "manifest.json")
        episodes = read_episodes(artifacts / "segment", manifest.labelled_once, SPLITS)
        self.episodes: list[MeasuredEpisode] = [episode for episode in episodes if episode.unbroken]

    def window_data(
        self,
        sources: Sequence[str],
        settings: TrainingSettings,
        recordings: Collection[str] | None = None,
    ) -> WindowData:
        """Return the windows of some sources, for training those of some recordings if given.

        Raises:
            InputError: a split has no window.
        """
        tracks = {}
        for split in SPLITS:
            chosen = [
                episode
                for episode in self.episodes
                if episode.split == split and episode.source in sources
            ]
            if split == TRAIN and recordings is not None:
                chosen = [episode for episode in chosen if episode.recording_id in recordings]
            try:
                tracks[split] = build_tracks([member.episode for member in chosen])
            except ValueError as error:
                problem = f"{error}: split {split} of {', '.join(sources)}"
                raise InputError(self.path, problem) from None
        return WindowData(tracks["train"], tracks["validation"], settings, self.seed)


def untrained_network(settings: NetworkSettings, data: WindowData) -> ForecastNetwork:
    """Return a network with weights drawn from the seed and its normaliser fitted to the data.

    Raises:
        InputError: the simulator of a hybrid cannot be read.
    """
    lightning.seed_everything(data.seed, verbose=False)
    simulator = load_simulator(settings.simulator) if isinstance(settings, HybridSettings) else None
    network = build_network(settings, simulator)
    data.fit_normaliser(network)
    return network
