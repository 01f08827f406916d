"""Training as a stage runs it: the same whether or not it was killed, and no orphan goes on."""

import errno
import os
import signal
from pathlib import Path

import pytest
import torch

from rallygap.models.predictors.training import ForecastTraining
from rallygap.pipeline.predictors.trainer import StepReporter, train
from tests.models.predictors.small_training import BRIEF, changed, small_training


def killed():
    raise RuntimeError("killed")


def terminated():
    os.kill(os.getpid(), signal.SIGTERM)


class Struck(ForecastTraining):
    """A training that counts its steps, and is struck before one of them."""

    steps, struck_at, strike = 0, None, staticmethod(killed)

    def training_step(self, batch):
        if self.global_step == self.struck_at:
            self.strike()
        self.steps += 1
        return super().training_step(batch)


def trained(checkpoints, **changes):
    training, data = small_training(changed(BRIEF, **changes), kind=Struck)
    train(training, data, checkpoints)
    return training


def struck(checkpoints, step, strike=killed, **changes):
    training, data = small_training(changed(BRIEF, **changes), kind=Struck)
    training.struck_at, training.strike = step, strike
    with pytest.raises((RuntimeError, SystemExit)) as stopped:
        train(training, data, checkpoints)
    return stopped.value


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


@pytest.mark.parametrize(
    ("changes", "step", "left"),
    [
        ({}, 2, 9),
        ({}, 3, 6),
        ({}, 8, 3),
        ({"decay": None}, 4, 6),
        ({"decay": None, "matrix_learning_rate": 0.01}, 4, 6),
    ],
)
def test_a_training_that_was_killed_goes_on_to_the_same_result(tmp_path, changes, step, left):
    assert str(struck(tmp_path / "killed", step, **changes)) == "killed"
    resumed = trained(tmp_path / "killed", **changes)
    assert_same(resumed, trained(tmp_path / "whole", **changes))
    assert resumed.steps == left  # from the last whole epoch, of three steps each


def test_a_terminated_training_can_be_resumed(uninterrupted, tmp_path):
    assert struck(tmp_path, 3, terminated).code == 143
    assert_same(trained(tmp_path), uninterrupted)


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


def test_a_training_that_is_done_is_not_done_again_and_nothing_is_printed(
    uninterrupted, tmp_path, capfd, recwarn
):
    trained(tmp_path)
    again = trained(tmp_path)
    assert again.steps == 0
    assert_same(again, uninterrupted)
    assert capfd.readouterr() == ("", "")
    assert [str(warning.message) for warning in recwarn] == []
