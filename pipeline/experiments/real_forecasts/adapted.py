"""Predictors that some recordings of a measured set adapt: amended, and fine-tuned."""

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.predictors.learned import ForecastNetwork
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.settings import TrainingSettings
from rallygap.models.predictors.training import WindowData
from rallygap.models.predictors.transformer import Transformer
from rallygap.models.predictors.window_dataset import build_tracks
from rallygap.pipeline.gap.shots import shots_of, source_shots
from rallygap.pipeline.io.episodes import MeasuredEpisode
from rallygap.pipeline.predictors.parallel_training import TrainingJob

HYBRID, TRANSFORMER, OTHER = "hybrid", "transformer", "transformer_2"


def amended_by(episodes: Sequence[MeasuredEpisode], nominal: Simulator) -> Simulator:
    """Return a simulator as the shots among some episodes amend it."""
    found = source_shots(episodes)
    return amended(nominal, diagnose(shots_of(found.members), nominal, nets=found.nets))


@dataclass(frozen=True)
class FineTuning:
    """Networks that are fine-tuned to some recordings.

    Attributes:
        transformer: trained on the arena.
        hybrid: trained on the arena.
        settings: of the fine-tuning.
        seed: of every draw.
    """

    transformer: ForecastNetwork
    hybrid: ForecastNetwork
    settings: TrainingSettings
    seed: int

    def jobs(
        self,
        episodes: Sequence[MeasuredEpisode],
        physics: PhysicsPredictor,
        name: str,
        folder: Path,
    ) -> Iterator[TrainingJob]:
        """Yield the trainings: of a hybrid that corrects this predictor, and two transformers.

        The second transformer sees other draws of windows. It is what an ensemble of a transformer
        and the hybrid is compared with.

        Args:
            episodes: to learn from.
            physics: with the simulator that these amend.
            name: of the trainings, and of their folders.
            folder: of checkpoints.
        """
        tracks = build_tracks([one.episode for one in episodes if one.unbroken])
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
            yield TrainingJob(f"{key}-{name}", network, own, folder / f"{key}-{name}")


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
