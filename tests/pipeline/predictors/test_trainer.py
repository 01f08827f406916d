"""Training as a stage runs it: the same whether or not it was killed on the way."""

import errno
import os
import signal
from pathlib import Path

import pytest
import torch
from torch.nn.utils import parameters_to_vector

from rallygap.models.predictors.training import ForecastTraining
from rallygap.pipeline.predictors.trainer import StepReporter, train
from tests.models.predictors.small_training import BRIEF, changed, small_training


class Killed(ForecastTraining):
    """A training that is killed before a step."""

    killed_at = 0

    def training_step(self, batch):
        if self.global_step == self.killed_at:
            raise RuntimeError("killed")
        return super().training_step(batch)


class Counted(ForecastTraining):
    """A training that counts its steps."""

    steps = 0

    def training_step(self, batch):
        self.steps += 1
        return super().training_step(batch)


def trained(checkpoints, seed=0):
    training, data = small_training(seed=seed, kind=Counted)
    train(training, data, checkpoints)
    return training


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    return trained(tmp_path_factory.mktemp("uninterrupted"))


def assert_same(training, other):
    weights, others = training.network.state_dict(), other.network.state_dict()
    assert weights.keys() == others.keys()
    assert all(torch.equal(weights[name], others[name]) for name in weights)
    assert training.curve == other.curve


def test_denormal_numbers_are_zero_while_a_network_is_trained(tmp_path):
    """On Intel's processors they would take a hundred times longer."""
    smallest, seen = torch.tensor([1e-40]), []
    training, data = small_training()
    train(training, data, tmp_path, [StepReporter(lambda _: seen.append((2 * smallest).item()))])
    assert set(seen) == {0.0}
    assert (2 * smallest).item() > 0.0


@pytest.mark.parametrize(("step", "left"), [(2, 9), (3, 6), (8, 3)])
def test_a_training_that_was_killed_goes_on_to_the_same_result(uninterrupted, tmp_path, step, left):
    killed, data = small_training(kind=Killed)
    killed.killed_at = step
    with pytest.raises(RuntimeError, match="killed"):
        train(killed, data, tmp_path / "checkpoints")

    resumed = trained(tmp_path / "checkpoints")

    assert_same(resumed, uninterrupted)
    assert resumed.steps == left  # from the last whole epoch, of three steps each


@pytest.mark.parametrize("matrix_learning_rate", [None, 0.01])
def test_a_training_with_another_rate_at_every_step_goes_on_as_well(tmp_path, matrix_learning_rate):
    settings = changed(BRIEF, decay=None, matrix_learning_rate=matrix_learning_rate)
    killed, data = small_training(settings, kind=Killed)
    killed.killed_at = 4
    with pytest.raises(RuntimeError, match="killed"):
        train(killed, data, tmp_path / "killed")
    resumed, uninterrupted = small_training(settings), small_training(settings)
    train(*resumed, tmp_path / "killed")
    train(*uninterrupted, tmp_path / "uninterrupted")
    assert_same(resumed[0], uninterrupted[0])


def test_a_checkpoint_for_which_the_disk_has_no_room_leaves_the_one_before(
    uninterrupted, tmp_path, monkeypatch
):
    write, written = Path.write_bytes, []

    def full(path, content):
        written.append(path)
        write(path, content if len(written) != 2 else content[: len(content) // 2])
        if len(written) == 2:
            raise OSError(errno.ENOSPC, "No space left on device", str(path))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="No space left"):
        trained(tmp_path)
    again = trained(tmp_path)
    assert again.steps == 2 * uninterrupted.steps / 3
    assert_same(again, uninterrupted)


class Terminated(ForecastTraining):
    """A training that gets SIGTERM in its second epoch."""

    def on_train_epoch_start(self):
        if self.current_epoch == 1:
            os.kill(os.getpid(), signal.SIGTERM)


def test_a_terminated_training_can_be_resumed(uninterrupted, tmp_path):
    training, data = small_training(kind=Terminated)
    with pytest.raises(SystemExit) as stopped:
        train(training, data, tmp_path / "checkpoints")
    assert stopped.value.code == 143
    assert_same(trained(tmp_path / "checkpoints"), uninterrupted)


def test_completed_steps_are_reported(tmp_path):
    reported = []
    killed, data = small_training(kind=Killed)
    killed.killed_at = 5
    with pytest.raises(RuntimeError, match="killed"):
        train(killed, data, tmp_path, [StepReporter(reported.append)])
    assert reported == [0, 1, 2, 3, 4, 5]
    training, data = small_training()
    train(training, data, tmp_path, [StepReporter(reported.append)])
    assert reported[6:] == [3, 4, 5, 6, 7, 8, 9]


def test_a_training_that_is_done_is_not_done_again_and_nothing_is_printed(
    uninterrupted, tmp_path, capfd, recwarn
):
    trained(tmp_path / "checkpoints")
    again = trained(tmp_path / "checkpoints")
    assert again.steps == 0
    assert_same(again, uninterrupted)
    assert capfd.readouterr() == ("", "")
    assert [str(warning.message) for warning in recwarn] == []


class Moved(ForecastTraining):
    """A training by plain descent, that notes how far each step moves the weights."""

    def configure_optimizers(self):
        return torch.optim.SGD(self.network.parameters(), lr=1.0)

    def on_train_start(self):
        self.moves = []

    def on_train_batch_start(self, *_):
        self.before = parameters_to_vector(self.network.parameters()).detach()

    def on_train_batch_end(self, *_):
        now = parameters_to_vector(self.network.parameters()).detach()
        self.moves.append((now - self.before).norm().item())


def moves(checkpoints, longest):
    training, data = small_training(changed(BRIEF, max_gradient_norm=longest, epochs=1), kind=Moved)
    train(training, data, checkpoints)
    return training.moves


def test_a_step_s_gradient_is_cut_to_the_longest_where_there_is_one(tmp_path):
    assert moves(tmp_path / "cut", 1e-3) == pytest.approx([1e-3] * 3, rel=1e-2)
    assert min(moves(tmp_path / "whole", None)) > 0.1


def test_half_precision_trains_full_weights(uninterrupted, tmp_path):
    training, data = small_training(changed(BRIEF, precision="bf16-mixed"))
    train(training, data, tmp_path / "checkpoints")
    assert training.curve[-1]["validation"] == pytest.approx(
        uninterrupted.curve[-1]["validation"], 0.05
    )
    assert {weight.dtype for weight in training.network.parameters()} == {torch.float32}
