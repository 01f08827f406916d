"""Train the predictors that learn: from measured balls alone, no physics told."""

import copy
from collections.abc import Mapping, Sequence

import lightning
import pandas as pd

from models.predictors.learned import ForecastNetwork, build_network
from models.predictors.settings import TrainingSettings
from models.predictors.training import WindowData
from models.predictors.window_dataset import Tracks, tracks
from pipeline.io.episodes import read_episodes
from pipeline.predictors.figures.training import training_figure
from pipeline.predictors.parallel_training import Pupil, train_networks
from pipeline.predictors.storage import Learning, TrainedPredictor, save_predictor
from pipeline.runtime.errors import InputError
from pipeline.runtime.stage_run import StageRun, run_stage
from pipeline.sources.manifest import read_manifest

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

    def train(
        self, networks: Mapping[str, ForecastNetwork], data: WindowData
    ) -> dict[str, ForecastNetwork]:
        """Return the networks trained; note their curves and the time they took."""
        pupils = [
            Pupil(name, network, data, self.run.scratch(name)) for name, network in networks.items()
        ]
        graduates = train_networks(pupils)
        for one in graduates:
            self.curves.append(one.curve.assign(predictor=one.name))
            self.run.timings[one.name] = {"training_s": round(one.seconds, 1)}
        return {one.name: one.network for one in graduates}

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
    trained = school.train(_untrained(run, data), data)
    for name, network in trained.items():
        _keep(run, name, network, data, settings.sources)
    if settings.fine_tuning.sources:
        _fine_tune(school, trained)
    _report(run, pd.concat(school.curves))


def _untrained(run: StageRun, data: WindowData) -> dict[str, ForecastNetwork]:
    """Return every network as it begins: its weights drawn, its normaliser fitted."""
    networks = {}
    for name, shape in run.params.train_predictor.networks.items():
        lightning.seed_everything(run.seed, verbose=False)
        networks[name] = build_network(shape)
        data.fit_normaliser(networks[name])
    return networks


def _fine_tune(school: School, trained: dict[str, ForecastNetwork]) -> None:
    settings = school.run.params.train_predictor
    changed = settings.fine_tuning.model_dump(exclude={"sources"})
    data = school.data(settings.fine_tuning.sources, settings.training.model_copy(update=changed))
    begun = {f"{name}{FINE_TUNED}": name for name in trained}
    tuned = school.train({name: copy.deepcopy(trained[one]) for name, one in begun.items()}, data)
    for name, network in tuned.items():
        _keep(school.run, name, network, data, settings.fine_tuning.sources, begun[name])


def _keep(
    run: StageRun,
    name: str,
    network: ForecastNetwork,
    data: WindowData,
    sources: list[str],
    starts_from: str | None = None,
) -> None:
    """Keep a trained network, with how it came by its weights."""
    learning = Learning(
        episodes=data.train.episodes,
        windows=data.train.episodes * data.settings.windows_an_episode * data.settings.epochs,
        validation_episodes=data.validation.episodes,
        settings=data.settings,
        seed=run.seed,
    )
    description = TrainedPredictor(
        name=name,
        network=run.params.train_predictor.networks[starts_from or name],
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
        "What remains is mostly the noise of the measured spin.",
    )
    run.add_table(
        curves.groupby("predictor", sort=False).tail(1)[columns],
        "training",
        title="Loss after the last epoch",
        caption="Mean squared error of the normalised states.",
    )


if __name__ == "__main__":
    run_stage(train_predictor)
