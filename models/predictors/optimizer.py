"""Muon for the layers' matrices, Adam for all else, as one optimizer.

A step of Muon turns a matrix by the orthogonal part of its momentum, so that every direction learns
at the same pace (Jordan 2024, https://kellerjordan.github.io/posts/muon). It is made for matrices
between hidden layers; what maps to and from the outer world, biases and normalisations stay Adam's.
"""

from collections.abc import Callable
from typing import Any

import torch
from torch import nn
from torch.optim import Adam, Muon, Optimizer

BETAS = (0.9, 0.98)  # of Adam's moments, as in Vaswani 2017: the default of 0.999 lags behind Muon


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
            Muon(hidden, lr=matrix_learning_rate, weight_decay=0.0),
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
            part.step()  # type: ignore[no-untyped-call]
        return loss

    def state_dict(self) -> dict[str, Any]:
        """Return what a training that goes on needs."""
        return {"parts": [part.state_dict() for part in self.parts]}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        """Go on from there."""
        for part, state in zip(self.parts, state_dict["parts"], strict=True):
            part.load_state_dict(state)
        self.param_groups = [group for part in self.parts for group in part.param_groups]
