"""Train the predictors that learn: from measured balls alone, no physics told."""

import copy
from collections.abc import Sequence

import lightning
import pandas as pd

from models.predictors.learned import ForecastNetwork, build_network
from models.predictors.settings import TrainingSettings
from models.predictors.tracks import Tracks, tracks
from models.predictors.training import ForecastTraining, WindowData
from pipeline.episodes import read_episodes
from pipeline.errors import InputError
from pipeline.figures.training import training_figure
from pipeline.run import StageRun, run_stage
from pipeline.sources.manifest import read_manifest
from pipeline.training import train
from pipeline.weights import Learning, TrainedPredictor, save_predictor

FINE_TUNED = "_fine_tuned"  # what fine-tuning adds to a predictor's name


class School:
    """Trains networks on the unbroken episodes of a run's training and validation recordings."""

    def __init__(self, run: StageRun) -> None:
        self.run = run
        self.path = run.input("segment", "episodes.parquet")
        manifest = read_manifest(run.input("ingest", "manifest.json"))
        read = read_episodes(
            run.input("segment", ""), manifest.labelled_once, ("train", "validation")
        )
        self.episodes = [one for one in read if one.unbroken]
        self.curves: list[pd.DataFrame] = []

    def data(self, sources: Sequence[str], settings: TrainingSettings) -> WindowData:
        """Return the windows of some sources.

        Raises:
            InputError: there is nothing in them to learn from.
        """
        train, validation = (self._tracks(split, sources) for split in ("train", "validation"))
        self.run.log_input("+".join(sources), self.path, train.episodes)
        return WindowData(train, validation, settings, self.run.seed)

    def train(self, name: str, network: ForecastNetwork, data: WindowData) -> Learning:
        """Train a network in place; note its curve and the time it took."""
        training = ForecastTraining(network, data.settings)
        train(training, data, name, self.run.scratch(name))
        self.curves.append(pd.DataFrame(training.curve).assign(predictor=name))
        self.run.timings[name] = {"training_s": round(training.seconds, 1)}
        return Learning(
            episodes=data.train.episodes,
            windows=data.train.episodes * data.settings.windows_an_episode * data.settings.epochs,
            validation_episodes=data.validation.episodes,
            settings=data.settings,
            seed=self.run.seed,
        )

    def _tracks(self, split: str, sources: Sequence[str]) -> Tracks:
        chosen = [one for one in self.episodes if one.split == split and one.source in sources]
        try:
            return tracks([one.episode for one in chosen])
        except ValueError as error:
            problem = f"{error}: split {split} of {', '.join(sources)}"
            raise InputError(self.path, problem) from None


def train_predictor(run: StageRun) -> None:
    """Train every network; let each go on with the balls of fine-tuning, where there are any."""
    settings = run.params.train_predictor
    school = School(run)
    data = school.data(settings.sources, settings.training)
    networks = {}
    for name, shape in settings.networks.items():
        lightning.seed_everything(run.seed, verbose=False)
        networks[name] = build_network(shape)
        data.fit_normaliser(networks[name])
        _learn(school, name, networks[name], data, settings.sources)
    if settings.fine_tuning.sources:
        _fine_tune(school, networks)
    _report(run, pd.concat(school.curves))


def _fine_tune(school: School, networks: dict[str, ForecastNetwork]) -> None:
    settings = school.run.params.train_predictor
    changed = settings.fine_tuning.model_dump(exclude={"sources"})
    data = school.data(settings.fine_tuning.sources, settings.training.model_copy(update=changed))
    for name, network in networks.items():
        tuned = copy.deepcopy(network)
        _learn(school, f"{name}{FINE_TUNED}", tuned, data, settings.fine_tuning.sources, name)


def _learn(
    school: School,
    name: str,
    network: ForecastNetwork,
    data: WindowData,
    sources: list[str],
    starts_from: str | None = None,
) -> None:
    """Train a network and keep it."""
    run = school.run
    learning = school.train(name, network, data)
    shape = run.params.train_predictor.networks[starts_from or name]
    description = TrainedPredictor(
        name=name,
        network=shape,
        parameters=network.parameter_count,
        sources=sources,
        starts_from=starts_from,
        learning=learning,
    )
    save_predictor(run.artifact(name), network, description)


def _report(run: StageRun, curves: pd.DataFrame) -> None:
    columns = ["predictor", "epoch", "training", "validation"]
    run.write_metrics(
        {
            str(name): {
                str(row["epoch"]): {key: float(f"{row[key]:.6g}") for key in columns[2:]}
                for row in curve.to_dict("records")
            }
            for name, curve in curves.groupby("predictor", sort=False)
        }
    )
    run.add_figure(
        training_figure(curves),
        "training",
        title="Training",
        caption="Mean squared error of the normalised states over the horizon, after each epoch. "
        "Validation windows are never learned from, and choose nothing: the last weights are kept. "
        "The floor is the noise of the measured spin.",
    )
    run.add_table(
        curves.groupby("predictor", sort=False).tail(1)[columns],
        "training",
        title="Loss after the last epoch",
        caption="Mean squared error of the normalised states.",
    )


if __name__ == "__main__":
    run_stage(train_predictor)
