"""Muon and Adam as one: each on its own share, resumed to the last bit."""

import copy

import torch
from torch import nn
from torch.optim import Adam, Muon
from torch.optim.lr_scheduler import LambdaLR

from rallygap.models.predictors.optimizer import MuonAndAdam, StackedMuon

RATE, MATRIX_RATE = 0.01, 0.1


class Layers(nn.Module):
    """Two layers and a projection, with a loss that pulls at every weight."""

    def __init__(self):
        super().__init__()
        torch.manual_seed(0)
        self.inner, self.outer = nn.Linear(8, 16), nn.Linear(16, 8)
        self.projection = nn.Linear(8, 3)

    def backward(self):
        rows = torch.randn(32, 8, generator=torch.Generator().manual_seed(0))
        self.projection(self.outer(self.inner(rows).tanh())).square().sum().backward()


def stepped(layers, optimizer):
    layers.backward()
    optimizer.step()
    return layers.state_dict()


def test_stacked_updates_equal_single_updates():
    torch.manual_seed(0)
    shapes = [(8, 8), (16, 8), (8, 8), (8, 16), (12, 8)]
    ours = [nn.Parameter(torch.randn(shape)) for shape in shapes]
    theirs = copy.deepcopy(ours)
    both = StackedMuon(ours, lr=RATE), Muon(theirs, lr=RATE, weight_decay=0.0)
    for _ in range(5):
        for one, other in zip(ours, theirs, strict=True):
            one.grad = torch.randn(one.shape)
            other.grad = one.grad.clone()
        for optimizer in both:
            optimizer.step()
    for one, other in zip(ours, theirs, strict=True):
        assert (one - other).abs().max() < RATE / 10  # after five steps; torch adds in 16 bits


def test_a_matrix_whose_gradient_vanishes_stays_while_others_of_its_size_move():
    dead, alive = (nn.Parameter(torch.zeros(8, 8)) for _ in range(2))
    optimizer = StackedMuon([dead, alive], lr=RATE)
    torch.manual_seed(0)
    dead.grad, alive.grad = 1e-25 * torch.randn(8, 8), torch.randn(8, 8)
    optimizer.step()
    assert not dead.any() and alive.all()


def test_a_step_is_that_of_muon_for_inner_matrices_and_of_adam_for_all_else():
    inner = {"inner.weight", "outer.weight"}
    layers, others = Layers(), Layers()
    moved = stepped(layers, MuonAndAdam(layers, RATE, MATRIX_RATE))
    named = dict(others.named_parameters())
    hidden = [named[name] for name in sorted(inner)]
    stepped(others, StackedMuon(hidden, lr=MATRIX_RATE, weight_decay=0.0))
    rest = [named[name] for name in named.keys() - inner]
    Adam(rest, lr=RATE, betas=(0.9, 0.98), fused=True).step()
    assert all(torch.equal(moved[name], value) for name, value in others.state_dict().items())


def test_a_schedule_changes_the_rates_of_both_after_a_resumption():
    layers = Layers()
    optimizer = MuonAndAdam(layers, RATE, MATRIX_RATE)
    optimizer.load_state_dict(optimizer.state_dict())
    before = copy.deepcopy(layers.state_dict())
    LambdaLR(optimizer, lambda _: 0.0)
    after = stepped(layers, optimizer)
    assert all(torch.equal(before[name], after[name]) for name in before)
