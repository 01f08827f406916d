"""A trained policy network, evaluated with numpy alone."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rallygap.models.policy.observation import Observations

Singles = NDArray[np.float32]


@dataclass(frozen=True)
class Policy:
    """The mean action of an actor: a fully connected network with ReLU, and tanh at the end.

    Attributes:
        layers: (out, in) weights and (out,) biases of each layer.
    """

    layers: tuple[tuple[Singles, Singles], ...]

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Singles]) -> "Policy":
        """Build a policy from the arrays of ``to_arrays``.

        Raises:
            ValueError: the arrays are not those of a policy.
        """
        count = len(arrays) // 2
        wanted = {f"{part}.{k}" for k in range(count) for part in ("weight", "bias")}
        if not count or wanted != set(arrays):
            raise ValueError(f"no policy has the arrays {', '.join(sorted(arrays))}")
        layers = tuple((arrays[f"weight.{k}"], arrays[f"bias.{k}"]) for k in range(count))
        inputs = layers[0][0].shape[-1:]
        for k, (weight, bias) in enumerate(layers):
            if bias.ndim != 1 or weight.shape != bias.shape + inputs:
                raise ValueError(f"weight.{k} does not fit the arrays before and after it")
            inputs = bias.shape
        return cls(layers)

    def to_arrays(self) -> dict[str, Singles]:
        """Return the weights by name."""
        named = {f"weight.{k}": weight for k, (weight, _) in enumerate(self.layers)}
        return named | {f"bias.{k}": bias for k, (_, bias) in enumerate(self.layers)}

    def act(self, observations: Observations) -> Singles:
        """Return (B, 5) actions in [-1, 1] for (B, O) observations."""
        rows = observations
        for number, (weight, bias) in enumerate(self.layers, 1):
            # Not ``@``: its order of summation, and so the last bit, depends on the number of
            # cores; and its threads contend with other processes, up to a hundred times slower.
            rows = np.einsum("bi,oi->bo", rows, weight) + bias
            rows = np.maximum(rows, 0.0) if number < len(self.layers) else np.tanh(rows)
        return rows
