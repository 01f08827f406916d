"""Fresh arenas: the gap workflow on worlds that its development has not looked at."""

import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from experiments.arena_scores import PREDICTORS
from experiments.recordings import record_arena
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.predictors.errors import HORIZONS_MS, error_norms
from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import ProbabilisticPredictor
from rallygap.models.predictors.training import ForecastTraining
from rallygap.pipeline.evaluation.evaluation_windows import read_test_sets
from rallygap.pipeline.evaluation.forecasts import forecast_windows
from rallygap.pipeline.evaluation.predictors import ARENA, ORACLE, NamedPredictor
from rallygap.pipeline.gap.cases import cases
from rallygap.pipeline.gap.shots import read_training_shots
from rallygap.pipeline.io.amended_simulators import AMENDED
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Params
from rallygap.pipeline.predictors.trainer import train
from rallygap.pipeline.predictors.training_data import TrainingEpisodes, untrained_network
from rallygap.pipeline.transfer.truth_comparison import NamedCause, number_table

NOMINAL, WITH_NET = "imperfect_c", "imperfect_c_with_net"
NETWORKS = ("transformer", "hybrid")


def arena_result(params: Params, seed: int, scratch: Path) -> dict[str, pd.DataFrame]:
    """Return the causes and the prediction errors on the arena of a seed.

    Args:
        params: of the pipeline; all that matters but the seed.
        seed: of physics, cameras, players and all else.
        scratch: folder in which recordings are for a while.

    Returns:
        ``causes``, as ``number_table`` has them, with the size that can be detected; and
        ``errors``, the position errors of simulators and networks on test recordings.
    """
    scratch.mkdir(parents=True, exist_ok=True)
    # Not by the seed alone: a worker that outlives its killed run may still be at this arena.
    with tempfile.TemporaryDirectory(dir=scratch, prefix=f"{seed}.") as name:
        folder = Path(name)
        truth = record_arena(params, seed, folder).simulator
        shots = {ARENA: read_training_shots(folder)[ARENA]}
        all_cases = cases(shots, params.close_gap, seed)
        diagnosed = next(case for case in all_cases if case.simulator_name == NOMINAL).diagnose()
        known = amended(diagnosed.case.simulator, diagnosed.verdict)
        simulators = {name: load_simulator(name) for name in (NOMINAL, WITH_NET)}
        simulators |= {AMENDED: known, ORACLE: truth}
        physics = {name: PhysicsPredictor(simulator) for name, simulator in simulators.items()}
        networks = _trained_networks(params, seed, folder)
        predictors: dict[str, ProbabilisticPredictor] = {**physics, **networks}
        named = [NamedPredictor(name, predictors[name], name) for name in (*PREDICTORS, ORACLE)]
        errors = _errors(params, folder, named)
    verdict = diagnosed.verdict
    causes = [
        NamedCause(identity=cause.identity, interval=cause.interval)
        for cause in verdict.main_causes
    ]
    table = number_table(diagnosed.case.simulator, known, causes, truth)
    identities = table["effect"] + "." + table["parameter"]
    table = table.assign(detectable=identities.map(verdict.minimum_detectable))
    return {"causes": table, "errors": errors}


def _trained_networks(params: Params, seed: int, artifacts: Path) -> dict[str, LearnedPredictor]:
    """Train networks as ``train_predictor`` does, one after another."""
    settings, trained = params.train_predictor, {}
    data = TrainingEpisodes(artifacts, seed).window_data([ARENA], settings.training)
    for name in NETWORKS:
        network = untrained_network(settings.networks[name], data)
        train(ForecastTraining(network, data.settings), data, artifacts / "checkpoints" / name)
        trained[name] = LearnedPredictor(network)  # no spread: only mean errors are compared
    return trained


def _errors(params: Params, folder: Path, named: list[NamedPredictor]) -> pd.DataFrame:
    (test,) = read_test_sets(folder, params.evaluate_predictor.window_every_ms / 1000)
    means = {
        name: np.nanmean(error_norms(forecast, test.windows, "position"), axis=0)
        for name, forecast in forecast_windows(test, named).items()
    }
    wide = pd.DataFrame(means, index=pd.Index(HORIZONS_MS, name="horizon_ms"))
    return wide.melt(var_name="predictor", value_name="mean", ignore_index=False).reset_index()
