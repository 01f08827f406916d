"""Muon for the layers' matrices, Adam for all else, as one optimizer.

A step of Muon turns a matrix by the orthogonal part of its momentum, so that every direction learns
at the same pace (Jordan 2024, https://kellerjordan.github.io/posts/muon). It is made for matrices
between hidden layers; what maps to and from the outer world, biases and normalisations stay Adam's.
"""

from collections.abc import Callable
from itertools import groupby
from typing import Any

import torch
from torch import Tensor, nn
from torch.optim import Adam, Muon, Optimizer

BETAS = (0.9, 0.98)  # of Adam's moments, as in Vaswani 2017: the default of 0.999 lags behind Muon
SMALLEST_NORM = 1e-7  # as torch's


class StackedMuon(Muon):
    """torch's Muon without weight decay, which turns all matrices of a size at once.

    One by one, the many small matrices of a network for two cores take longer than its forward.
    """

    @torch.no_grad()
    def step(self, closure: None = None) -> None:  # type: ignore[override]
        """Take one step along the gradients."""
        for group in self.param_groups:
            sorted_by_size = sorted(group["params"], key=_wide_size)
            for _, members in groupby(sorted_by_size, key=_wide_size):
                self._turn(list(members), group)

    def _turn(self, members: list[Tensor], group: dict[str, Any]) -> None:
        """Turn matrices of one size, be they tall or wide."""
        turned = _orthogonal(
            torch.stack([_wide(self._velocity(one, group["momentum"])) for one in members]),
            group["ns_coefficients"],
            group["ns_steps"],
        )
        for one, direction in zip(members, turned, strict=True):
            rate = group["lr"] * max(1.0, one.shape[0] / one.shape[1]) ** 0.5
            one.add_(direction if one.shape == direction.shape else direction.T, alpha=-rate)

    def _velocity(self, one: Tensor, momentum: float) -> Tensor:
        """Return Nesterov's: the gradient, drawn towards what it has been of late."""
        state, gradient = self.state[one], one.grad
        if gradient is None:
            raise ValueError("a matrix without a gradient cannot be turned")
        if not state:
            state["momentum_buffer"] = torch.zeros_like(gradient)
        average = state["momentum_buffer"].lerp_(gradient, 1 - momentum)
        return gradient.lerp(average, momentum)


def _wide(matrix: Tensor) -> Tensor:
    return matrix.T if matrix.shape[0] > matrix.shape[1] else matrix


def _wide_size(matrix: Tensor) -> tuple[int, ...]:
    return tuple(sorted(matrix.shape))


def _orthogonal(stack: Tensor, coefficients: tuple[float, float, float], steps: int) -> Tensor:
    """Return about the orthogonal parts of (N, R, C) matrices, R <= C, by Newton and Schulz.

    In 32 bits: torch's 16 are faster on a GPU alone, and most processors have to imitate them.
    """
    a, b, c = coefficients
    parts: Tensor = stack / stack.norm(dim=(1, 2), keepdim=True).clamp(min=SMALLEST_NORM)
    for _ in range(steps):
        gram = parts @ parts.mT
        change = torch.baddbmm(gram, gram, gram, beta=b, alpha=c)
        parts = torch.baddbmm(parts, change, parts, beta=a)
    return parts


class MuonAndAdam(Optimizer):
    """Two optimizers that step together.

    Args:
        network: what to train. Its matrices called ``projection`` are Adam's.
        learning_rate: Adam's.
        matrix_learning_rate: Muon's.
    """

    def __init__(
        self, network: nn.Module, learning_rate: float, matrix_learning_rate: float
    ) -> None:
        hidden: list[nn.Parameter] = []
        other: list[nn.Parameter] = []
        for name, parameter in network.named_parameters():
            inner = parameter.ndim == 2 and "projection" not in name
            (hidden if inner else other).append(parameter)
        self.parts = (
            StackedMuon(hidden, lr=matrix_learning_rate, weight_decay=0.0),
            Adam(other, lr=learning_rate, betas=BETAS, fused=True),
        )
        super().__init__([{"params": [*hidden, *other]}], {})
        # A schedule that changes the rates here changes them in the parts.
        self.param_groups = [group for part in self.parts for group in part.param_groups]

    def step(self, closure: Callable[[], float] | None = None) -> float | None:  # type: ignore[override]
        """Take one step with each; ``closure`` computes the gradients first."""
        loss = None
        if closure is not None:
            with torch.enable_grad():
                loss = closure()
        for part in self.parts:
            part.step()
        return loss

    def state_dict(self) -> dict[str, Any]:
        """Return what a training that goes on needs."""
        return {"parts": [part.state_dict() for part in self.parts]}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        """Go on from there."""
        for part, state in zip(self.parts, state_dict["parts"], strict=True):
            part.load_state_dict(state)
        self.param_groups = [group for part in self.parts for group in part.param_groups]
