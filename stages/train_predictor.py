"""Train the networks that forecast, from measured balls alone, and fine-tune them."""

import copy
from collections.abc import Mapping

import pandas as pd

from rallygap.models.predictors.learned import ForecastNetwork
from rallygap.models.predictors.training import WindowData
from rallygap.pipeline.io.artifacts import write_csv
from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.predictors.parallel_training import (
    TrainingJob,
    TrainingResult,
    train_networks,
)
from rallygap.pipeline.predictors.storage import Learning, TrainedPredictor, save_predictor
from rallygap.pipeline.predictors.training_data import TrainingEpisodes, untrained_network
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.tracking.results import TrainedModel

FINE_TUNED = "_fine_tuned"  # suffix of fine-tuned predictors


def train_predictor(run: StageRun) -> None:
    """Train every network; fine-tune a copy of each where ``fine_tuning`` names sources."""
    settings, tuning = run.params.train_predictor, run.params.train_predictor.fine_tuning
    episodes = TrainingEpisodes(run.root / "artifacts", run.seed)
    data = episodes.window_data(settings.sources, settings.training)
    networks = {
        name: untrained_network(network, data) for name, network in settings.networks.items()
    }
    results = _train(run, networks, data, settings.sources)
    for result in results:
        _save(run, result, data, settings.sources)
    if tuning.sources:
        changed = settings.training.model_copy(update=tuning.model_dump(exclude={"sources"}))
        data = episodes.window_data(tuning.sources, changed)
        copies = {f"{result.name}{FINE_TUNED}": copy.deepcopy(result.network) for result in results}
        tuned = _train(run, copies, data, tuning.sources)
        for result in tuned:
            _save(run, result, data, tuning.sources, result.name.removesuffix(FINE_TUNED))
        results = [*results, *tuned]
    curves = pd.concat([result.curve.assign(predictor=result.name) for result in results])
    last = curves.groupby("predictor", sort=False).last()
    run.write_metrics({str(name): rounded(loss) for name, loss in last["validation"].items()})
    run.keep(losses=curves)
    write_csv(run.report("losses.csv"), curves)


def _train(
    run: StageRun, networks: Mapping[str, ForecastNetwork], data: WindowData, sources: list[str]
) -> list[TrainingResult]:
    path = run.input("segment", "episodes.parquet")
    run.log_input("+".join(sources), path, data.train.episodes)
    results = train_networks(
        [TrainingJob(name, network, data, run.scratch(name)) for name, network in networks.items()]
    )
    for result in results:
        run.timings[result.name] = {"training_s": round(result.seconds, 1)}
    return results


def _save(
    run: StageRun,
    result: TrainingResult,
    data: WindowData,
    sources: list[str],
    starts_from: str | None = None,
) -> None:
    learning = Learning(
        episodes=data.train.episodes,
        windows=data.train.episodes * data.settings.windows_per_episode * data.settings.epochs,
        validation_episodes=data.validation.episodes,
        settings=data.settings,
        seed=run.seed,
    )
    description = TrainedPredictor(
        name=result.name,
        network=run.params.train_predictor.networks[starts_from or result.name],
        parameters=result.network.parameter_count,
        sources=sources,
        starts_from=starts_from,
        learning=learning,
    )
    folder = run.artifact(result.name)
    save_predictor(folder, result.network, result.spread, description)
    name, loss = f"predictor-{result.name}-{'+'.join(sources)}", result.curve["validation"].iloc[-1]
    digest = run.inputs[-1].digest
    run.models.append(TrainedModel(name, folder, "validation_loss", float(loss), True, digest))


if __name__ == "__main__":
    run_stage(train_predictor)
