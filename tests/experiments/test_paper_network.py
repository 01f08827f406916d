"""The paper's network: its settings, its training and what is published of it."""

import joblib
import pandas as pd
import pytest
import torch

import experiments.stages.paper_network as run
from experiments import paper_network
from experiments.paper_network import read_trained_network, write_trained
from rallygap.models.predictors.settings import TrainingSettings
from rallygap.models.predictors.training import ForecastTraining
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.predictors.trainer import train
from rallygap.pipeline.predictors.training_data import untrained_network
from rallygap.pipeline.profiles import profile_params
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import repository_root
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.experiments.made_up import few_balls
from tests.models.predictors.small_training import BRIEF, TINY, changed, data, small_training
from tests.pipeline.killed_runs import kill_at
from tests.pipeline.measured_shots import write_trained as write_kept

SMALL = few_balls({"transformer": TINY})


@pytest.fixture
def stage(tmp_path, monkeypatch):
    """A run with a kept predictor, and settings of a tiny network."""
    write_kept(tmp_path, "transformer")
    kept = tmp_path / run.SMALLER
    kept.parent.mkdir(parents=True)
    (tmp_path / "artifacts" / "train_predictor").rename(kept)
    monkeypatch.setattr(run, "profile_params", lambda root, name: SMALL)
    monkeypatch.setattr(run, "EPOCHS", 3)
    with joblib.parallel_config(backend="sequential"):
        yield StageRun("paper_network", tmp_path, SMALL)


def test_sizes_batches_and_learning_rates_are_those_of_the_paper():
    """Section IV-A: batches of 128, Adam from 0.0001, which decays by 0.95 per epoch."""
    paper = profile_params(repository_root(), run.PROFILE).train_predictor
    network = paper.networks[run.NETWORK]
    assert (network.width, network.encoder_layers, network.decoder_layers) == (512, 3, 2)
    ours = TrainingSettings.model_validate(run.on_gpu(paper.training).model_dump())
    assert (ours.batch, ours.learning_rate, ours.decay) == (128, 1e-4, 0.95)
    assert ours.matrix_learning_rate is None and ours.max_gradient_norm is None


@pytest.mark.parametrize("batch", [7, 23])
def test_prepared_batches_train_the_same_network(tmp_path, monkeypatch, batch):
    """Bit for bit: the same windows, in the same batches and groups of any size."""
    monkeypatch.setattr(paper_network, "AT_ONCE", 2)
    settings = changed(BRIEF, batch=batch)
    plain, windows = small_training(settings)
    training, _ = small_training(settings, kind=paper_network.PreparedTraining)
    train(plain, windows, tmp_path / "plain")
    train(training, paper_network.PreparedData(windows, training.network), tmp_path / "prepared")
    assert training.curve == plain.curve
    pairs = zip(training.network.parameters(), plain.network.parameters(), strict=True)
    assert all(torch.equal(*pair) for pair in pairs)


def test_a_trained_network_is_read_as_it_was_trained(tmp_path):
    write_trained("tiny", TINY, data(), tmp_path)
    network, record = read_trained_network(TINY, tmp_path)
    same = untrained_network(TINY, data())
    train(ForecastTraining(same, BRIEF), data(), tmp_path / "same")
    history, mask, *_ = data().validation.windows(data().validation.anchors[:3])
    with torch.no_grad():
        forecasts = [one(history, mask) for one in (network, same.eval())]
    assert torch.equal(*forecasts)
    assert [row["epoch"] for row in record["curve"]] == [1, 2, 3]
    assert record["training_episodes"] == data().train.episodes


def test_without_a_gpu_nothing_is_simulated(stage, monkeypatch):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    monkeypatch.delattr(run, "record_arena")
    with pytest.raises(InputError, match="is trained on a GPU"):
        run.paper_network(stage)


def test_a_killed_run_resumes_and_publishes_errors(stage, monkeypatch):
    monkeypatch.setattr(run, "_check_gpu", lambda folder: None)
    kill_at(run, "_errors", run.paper_network, stage)
    assert not stage.report(".").exists()
    monkeypatch.delattr(run, "record_arena")
    monkeypatch.delattr(run, "write_trained")
    run.paper_network(stage)
    errors = pd.read_csv(stage.report("errors.csv"))
    means = errors.query("quantity == 'position' and bounce == 'all' and horizon_ms == 200")
    means = means.set_index("predictor")["mean"]
    assert list(means.index) == [*run.PHYSICS, "transformer", "oracle", "paper_network"]
    assert means["oracle"] < means["physics_c"] < means["paper_network"]
    differences = pd.read_csv(stage.report("differences.csv"))
    assert set(differences["predictor"]) == {"paper_network"}
    assert pd.read_csv(stage.report("training.csv"))["epoch"].tolist() == [*range(1, 4)]
    assert read_json(stage.report("network.json"))["seed"] == SMALL.seed
