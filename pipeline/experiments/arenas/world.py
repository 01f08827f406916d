"""One fresh arena: what the gap workflow says of it, and how well it is predicted."""

import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.predictors.errors import HORIZONS_MS, error_norms
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import ProbabilisticPredictor
from rallygap.pipeline.evaluation.evaluation_windows import read_test_sets
from rallygap.pipeline.evaluation.forecasts import forecast_windows
from rallygap.pipeline.evaluation.predictors import ARENA, ORACLE, NamedPredictor
from rallygap.pipeline.experiments.arenas.networks import trained_networks
from rallygap.pipeline.experiments.arenas.recordings import record_arena
from rallygap.pipeline.experiments.arenas.scores import PREDICTORS
from rallygap.pipeline.gap.cases import Diagnosed, cases
from rallygap.pipeline.gap.shots import read_training_shots
from rallygap.pipeline.io.amended_simulators import AMENDED
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Params
from rallygap.pipeline.transfer.truth_comparison import NamedCause, number_table

NOMINAL, WITH_NET = "imperfect_c", "imperfect_c_with_net"


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
        truth = record_arena(params, seed, folder)
        shots = {ARENA: read_training_shots(folder)[ARENA]}
        found = cases(shots, params.close_gap, seed)
        diagnosed = next(one for one in found if one.simulator_name == NOMINAL).diagnose()
        known = amended(diagnosed.case.simulator, diagnosed.verdict)
        simulators = {AMENDED: known, ORACLE: truth.simulator}
        predictors = {**_physics(simulators), **trained_networks(params, seed, folder)}
        errors = _errors(params, folder, predictors)
    return {"causes": _causes(diagnosed, known, truth.simulator), "errors": errors}


def _causes(diagnosed: Diagnosed, known: Simulator, truth: Simulator) -> pd.DataFrame:
    verdict = diagnosed.verdict
    causes = [
        NamedCause(identity=one.identity, interval=one.interval) for one in verdict.main_causes
    ]
    table = number_table(diagnosed.case.simulator, known, causes, truth)
    identities = table["effect"] + "." + table["parameter"]
    return table.assign(detectable=identities.map(verdict.minimum_detectable))


def _physics(simulators: Mapping[str, Simulator]) -> dict[str, ProbabilisticPredictor]:
    nominal = {name: load_simulator(name) for name in (NOMINAL, WITH_NET)}
    return {name: PhysicsPredictor(one) for name, one in {**nominal, **simulators}.items()}


def _errors(
    params: Params, folder: Path, predictors: Mapping[str, ProbabilisticPredictor]
) -> pd.DataFrame:
    named = [NamedPredictor(name, predictors[name], name) for name in (*PREDICTORS, ORACLE)]
    (test,) = read_test_sets(folder, params.evaluate_predictor.window_every_ms / 1000)
    forecasts = forecast_windows(test, named)
    means = {
        name: np.nanmean(error_norms(one, test.windows, "position"), axis=0)
        for name, one in forecasts.items()
    }
    wide = pd.DataFrame(means, index=pd.Index(HORIZONS_MS, name="horizon_ms"))
    return wide.melt(var_name="predictor", value_name="mean", ignore_index=False).reset_index()
