"""The paper's network, trained on a GPU in ten minutes.

The transformer has the paper's size and learns from the paper's number of shots (profile
``paper_network``), for fewer epochs and with fewer bits. It forecasts test recordings next to the
smaller networks of the profile ``paper``, which have learned from the same shots.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import torch

from experiments.paper_network import RECORD, read_trained_network, write_trained
from experiments.recordings import record_arena
from rallygap.models.arena.truth import Truth
from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS, ForecastErrors
from rallygap.models.predictors.learned import ForecastNetwork, LearnedPredictor
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.settings import TrainingSettings
from rallygap.pipeline.evaluation.evaluation_windows import read_test_sets
from rallygap.pipeline.evaluation.forecasts import evaluate, forecast_windows
from rallygap.pipeline.evaluation.predictors import ARENA, ORACLE, NamedPredictor, read_trained
from rallygap.pipeline.io.artifacts import read_json, write_json
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Params
from rallygap.pipeline.predictors.training_data import TrainingEpisodes
from rallygap.pipeline.profiles import profile_params
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

NAME, PROFILE, NETWORK = "paper_network", "paper_network", "transformer"
PHYSICS = {"physics_c": "imperfect_c", "physics_c_with_net": "imperfect_c_with_net"}
SMALLER = "artifacts/profiles/paper/train_predictor"  # that have learned from the same shots
# In 32 bits the GPU itself takes longer than its processor to start a step. The paper's last 20 of
# 80 epochs have less than a twentieth of the first learning rate.
PRECISION, EPOCHS = "bf16-mixed", 60


def paper_network(run: StageRun) -> None:
    """Write the errors of the paper's network, and its learning curve.

    Raises:
        InputError: there is no GPU.
    """
    params, scratch = profile_params(run.root, PROFILE), run.scratch("trained")
    _check_gpu(scratch)
    truth = _recorded(params, scratch)
    network, record = _trained(params, scratch)
    errors = _errors(params, scratch, [*_predictors(run.root, truth, network)])
    table, curve = errors.over_horizon(), pd.DataFrame(record.pop("curve"))
    shown = table[table["horizon_ms"].isin(SHOWN_HORIZONS_MS)]
    differences = errors.differences([NAME])
    run.publish({"errors": shown, "differences": differences, "training": curve})
    sample = {"seed": run.seed, "parameters": network.parameter_count, **record}
    write_json(run.report("network.json"), sample)


def _check_gpu(scratch: Path) -> None:
    if not (scratch / RECORD).exists() and not torch.cuda.is_available():
        raise InputError("the paper's network", "is trained on a GPU; torch finds none here")


def _recorded(params: Params, scratch: Path) -> Truth:
    """Return the truth behind the recordings, which a killed run may have made."""
    path = scratch / "truth.json"
    if not path.exists():
        write_json(path, record_arena(params, params.seed, scratch).to_dict())
    return Truth.from_dict(read_json(path))


def _trained(params: Params, scratch: Path) -> tuple[ForecastNetwork, dict[str, Any]]:
    settings = params.train_predictor
    network = settings.networks[NETWORK]
    if not (scratch / RECORD).exists():
        episodes = TrainingEpisodes(scratch, params.seed)
        data = episodes.window_data([ARENA], on_gpu(settings.training))
        write_trained(NAME, network, data, scratch)
    return read_trained_network(network, scratch)


def on_gpu(settings: TrainingSettings) -> TrainingSettings:
    """Return the paper's settings with fewer bits and fewer epochs."""
    return settings.model_copy(update={"precision": PRECISION, "epochs": EPOCHS})


def _predictors(root: Path, truth: Truth, network: ForecastNetwork) -> Iterator[NamedPredictor]:
    for name, simulator in PHYSICS.items():
        yield NamedPredictor(name, PhysicsPredictor(load_simulator(simulator)), "physics")
    yield from read_trained(root / SMALLER)
    yield NamedPredictor(ORACLE, PhysicsPredictor(truth.simulator), ORACLE)
    yield NamedPredictor(NAME, LearnedPredictor(network), NETWORK)


def _errors(params: Params, scratch: Path, predictors: list[NamedPredictor]) -> ForecastErrors:
    settings = params.evaluate_predictor
    (test,) = read_test_sets(scratch, settings.window_every_ms / 1000)
    forecasts = forecast_windows(test, predictors)
    return evaluate(forecasts, test.windows, test, settings, params.seed)


if __name__ == "__main__":
    run_stage(paper_network)
