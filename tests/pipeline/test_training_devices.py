"""Processes that share every batch train the network that one process trains."""

import copy
import os
import signal
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest
import torch

from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.protocol import History
from rallygap.models.predictors.training import ForecastTraining
from rallygap.pipeline.predictors.parallel_training import TrainingJob, train_networks
from rallygap.pipeline.predictors.trainer import train
from rallygap.pipeline.runtime.errors import InputError
from tests.models.predictors.small_training import (
    BRIEF,
    NETWORKS,
    changed,
    data,
    fit,
    small_training,
)


class Watched(ForecastTraining):
    """A training whose every process says where it listens."""

    message = Path()

    def on_train_start(self):
        mine = psutil.Process().net_connections("inet")
        listening = {one.laddr.ip for one in mine if one.status == psutil.CONN_LISTEN}
        (self.message / str(self.global_rank)).write_text(" ".join(listening))


class KilledOnce(ForecastTraining):
    """A training whose second process is killed in the second epoch."""

    def on_train_epoch_start(self):
        super().on_train_epoch_start()
        if (self.current_epoch, self.global_rank) == (1, 1):
            os.kill(os.getpid(), signal.SIGKILL)


def trained(folder, devices, kind=ForecastTraining, **changes):
    training, windows = small_training(changed(BRIEF, devices=devices, **changes), kind=kind)
    train(training, windows, folder)
    return training


def assert_close(training, other):
    for weights, others in zip(
        training.network.parameters(), other.network.parameters(), strict=True
    ):
        # Nine steps of 0.01. Where a gradient is about nothing, Adam makes steps of its rounding.
        torch.testing.assert_close(weights, others, rtol=0, atol=3e-3)
    assert len(training.curve) == len(other.curve)
    for record, expected in zip(training.curve, other.curve, strict=True):
        assert record == pytest.approx(expected, rel=1e-3)


def test_more_gpus_than_there_are_is_one_error(tmp_path, monkeypatch):
    monkeypatch.setattr("torch.cuda.is_available", lambda: True)
    monkeypatch.setattr("torch.cuda.device_count", lambda: 1)
    with pytest.raises(InputError, match=r"train_predictor\.training\.devices: .*machine only has"):
        trained(tmp_path, 2)


@pytest.mark.parametrize("batch", [8, 7, 23])
def test_shares_of_a_batch_are_the_batch(batch):
    """Be it whole, odd, or of one window, as the last one may be."""
    whole, *shares = [data(changed(BRIEF, batch=batch)) for _ in range(3)]
    for rank, share in enumerate(shares):
        here = SimpleNamespace(root_device=torch.device("cpu"))
        ranked = {"global_rank": rank, "world_size": 2, "current_epoch": 0, "strategy": here}
        share.trainer = SimpleNamespace(**ranked)
    loaders = [one.train_dataloader() for one in (whole, *shares)]
    assert len({len(loader) for loader in loaders}) == 1
    for batch_of_all, *parts in zip(*loaders, strict=True):
        for column, *columns in zip(batch_of_all, *parts, strict=True):
            together = torch.empty_like(column)
            together[0::2], together[1::2] = columns
            assert torch.equal(together, column)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a GPU")
@pytest.mark.parametrize("shape", NETWORKS.values(), ids=NETWORKS)
def test_a_gpu_trains_what_a_processor_does(shape, tmp_path):
    with_gpu, windows = small_training(shape=shape)
    without, same_windows = small_training(shape=shape)
    job = TrainingJob("network", with_gpu.network, windows, tmp_path)
    (result,) = train_networks([job])
    fit(without, same_windows, accelerator="cpu")
    losses = [record["training"] for record in without.curve]
    np.testing.assert_allclose(result.curve["training"], losses, rtol=1e-2)
    history, mask, _, _ = windows.train.windows(windows.train.anchors)
    seen = History(history.numpy().astype(float), mask.numpy())
    here = LearnedPredictor(result.network, result.spread)
    states, covariances = here.predict_with_covariances(seen)
    there = LearnedPredictor(copy.deepcopy(result.network).cuda(), result.spread.cuda())
    moved, others = there.predict_with_covariances(seen)
    np.testing.assert_allclose(moved.states, states.states, atol=1e-2)
    np.testing.assert_allclose(others, covariances, rtol=1e-2, atol=1e-6)


two_processes = pytest.mark.skipif(torch.cuda.device_count() == 1, reason="each needs its own GPU")


@two_processes
@pytest.mark.slow
@pytest.mark.parametrize(
    ("batch", "matrix_learning_rate"),
    [(8, None), (7, 0.01), (23, None)],  # even shares, odd ones, and a last one that is empty
)
def test_two_processes_train_what_one_does(tmp_path, batch, matrix_learning_rate):
    changes = {"batch": batch, "matrix_learning_rate": matrix_learning_rate}
    alone = trained(tmp_path / "1", 1, **changes)
    together = trained(tmp_path / "2", 2, **changes)
    assert_close(together, alone)


@two_processes
@pytest.mark.slow
def test_two_processes_print_nothing_and_listen_on_loopback_alone(tmp_path, capfd):
    training, windows = small_training(changed(BRIEF, devices=2, epochs=1), kind=Watched)
    training.message = tmp_path
    train(training, windows, tmp_path / "checkpoints")
    assert [(tmp_path / rank).read_text() for rank in ("0", "1")] == ["127.0.0.1"] * 2
    assert capfd.readouterr() == ("", "")


@two_processes
@pytest.mark.slow
def test_processes_of_which_one_was_killed_go_on_from_the_last_epoch(tmp_path):
    with pytest.raises(torch.multiprocessing.ProcessExitedException, match="SIGKILL"):
        trained(tmp_path / "2", 2, kind=KilledOnce)
    assert_close(trained(tmp_path / "2", 2), trained(tmp_path / "1", 1))
