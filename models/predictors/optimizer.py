"""Muon for the layers' matrices, Adam for all else, as one optimizer.

A step of Muon moves a matrix along the orthogonalised momentum, so that all directions learn at the
same rate (Jordan 2024, https://kellerjordan.github.io/posts/muon). It applies to matrices between
hidden layers; input and output projections, biases and normalisations are trained by Adam.
"""

from collections.abc import Callable
from itertools import groupby
from typing import Any

import torch
from torch import Tensor, nn
from torch.optim import Adam, Muon, Optimizer

BETAS = (0.9, 0.98)  # Adam's, as in Vaswani 2017; the default of 0.999 lags behind Muon
MIN_NORM = 1e-7  # as torch's; smaller directions are none


class StackedMuon(Muon):
    """torch's Muon without weight decay, with one batched update for all matrices of a size.

    Updating the many small matrices one by one takes longer than the forward pass on two cores.
    """

    @torch.no_grad()
    def step(self, closure: None = None) -> None:  # type: ignore[override]
        """Take one step along the gradients."""
        for group in self.param_groups:
            ordered = sorted(group["params"], key=_wide_size)
            for _, members in groupby(ordered, key=_wide_size):
                self._update_matrices(list(members), group)

    def _update_matrices(self, members: list[Tensor], group: dict[str, Any]) -> None:
        """Update matrices of one size, tall or wide."""
        velocities = [_wide(self._velocity(matrix, group["momentum"])) for matrix in members]
        directions = _orthogonal(
            torch.stack(velocities), group["ns_coefficients"], group["ns_steps"]
        )
        for matrix, direction in zip(members, directions, strict=True):
            rate = group["lr"] * max(1.0, matrix.shape[0] / matrix.shape[1]) ** 0.5
            matrix.add_(direction if matrix.shape == direction.shape else direction.T, alpha=-rate)

    def _velocity(self, matrix: Tensor, momentum: float) -> Tensor:
        """Return the Nesterov momentum of a gradient."""
        state, gradient = self.state[matrix], matrix.grad
        if gradient is None:
            raise ValueError("a matrix without a gradient cannot be updated")
        if not state:
            state["momentum_buffer"] = torch.zeros_like(gradient)
        average = state["momentum_buffer"].lerp_(gradient, 1 - momentum)
        return gradient.lerp(average, momentum)


def _wide(matrix: Tensor) -> Tensor:
    return matrix.T if matrix.shape[0] > matrix.shape[1] else matrix


def _wide_size(matrix: Tensor) -> tuple[int, ...]:
    return tuple(sorted(matrix.shape))


def _orthogonal(stack: Tensor, coefficients: tuple[float, float, float], steps: int) -> Tensor:
    """Return the approximate orthogonal factors of (N, R, C) matrices, R <= C, by Newton-Schulz.

    In 32 bits: torch's bfloat16 is faster on GPUs only. The factor of a matrix whose norm is below
    MIN_NORM is zero: its products would be denormal numbers, which take 25 times longer.
    """
    a, b, c = coefficients
    norms = stack.norm(dim=(1, 2), keepdim=True)
    parts = torch.where(norms < MIN_NORM, 0.0, stack / norms.clamp(min=MIN_NORM))
    for _ in range(steps):
        gram = parts @ parts.mT
        change = torch.baddbmm(gram, gram, gram, beta=b, alpha=c)
        parts = torch.baddbmm(parts, change, parts, beta=a)
    return parts


class MuonAndAdam(Optimizer):
    """Two optimizers that step together.

    Args:
        network: to be trained; Adam trains the parameters with ``projection`` in their names.
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
        """Return the state to resume from."""
        return {"parts": [part.state_dict() for part in self.parts]}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        """Restore a state."""
        for part, state in zip(self.parts, state_dict["parts"], strict=True):
            part.load_state_dict(state)
        self.param_groups = [group for part in self.parts for group in part.param_groups]
