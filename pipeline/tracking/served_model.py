"""A trained predictor or policy as MLflow loads and serves it: arrays in, arrays out.

``mlflow.pyfunc`` imports this module and hands it the folder that the stage wrote: weights as
safetensors, the rest as JSON. Nothing in a logged model is pickled, so none runs code.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rallygap.models.policy.policy import Policy
from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.protocol import History
from rallygap.pipeline.policies import storage as policies
from rallygap.pipeline.predictors.storage import load_predictor

Arrays = dict[str, NDArray[Any]]


class ServedPredictor:
    """A predictor behind MLflow's interface."""

    def __init__(self, predictor: LearnedPredictor) -> None:
        self.predictor = predictor

    def predict(self, inputs: Arrays, params: dict[str, Any] | None = None) -> Arrays:
        """Forecast each ball.

        Args:
            inputs: ``states`` (B, 12, 6) position (m) and spin (rad/s), zero where not measured,
                and ``mask`` of the same shape, true where measured.
            params: MLflow's; there are none.

        Returns:
            ``states`` (B, 60, 9) position (m), velocity (m/s), spin (rad/s), 5 to 300 ms ahead,
            and ``spin_measured`` (B,).
        """
        forecast = self.predictor.predict(History(inputs["states"], inputs["mask"]))
        return {"states": forecast.states, "spin_measured": forecast.spin_measured}

    def example(self) -> Arrays:
        """One window: a ball that flies at 8 m/s to the robot under gravity, with topspin."""
        times = 0.005 * np.arange(-11, 1)
        states = np.zeros((1, 12, 6))
        states[0, :, 1] = 1.0 - 8.0 * times
        states[0, :, 2] = 0.3 + 2.0 * times - 4.9 * times**2
        states[0, :, 3] = 100.0
        return {"states": states, "mask": np.ones((1, 12, 6), dtype=bool)}


class ServedPolicy:
    """A policy behind MLflow's interface."""

    def __init__(self, policy: Policy) -> None:
        self.policy = policy

    def predict(self, inputs: Arrays, params: dict[str, Any] | None = None) -> Arrays:
        """Choose the action of each environment.

        Args:
            inputs: ``observations`` (B, O), scaled as in ``models/policy/observation.py``.
            params: MLflow's; there are none.

        Returns:
            ``actions`` (B, 5) in [-1, 1], as ``BatchSimulation.step`` takes them.
        """
        return {"actions": self.policy.act(inputs["observations"])}

    def example(self) -> Arrays:
        """The middle of every observed quantity."""
        return {"observations": np.zeros((1, self.policy.layers[0][0].shape[1]), np.float32)}


def _load_pyfunc(folder: str) -> ServedPredictor | ServedPolicy:
    """Load the model of a folder: the name that MLflow calls."""
    path = Path(folder)
    if (path / policies.DESCRIPTION).exists():
        return ServedPolicy(policies.load_policy(path)[0])
    return ServedPredictor(load_predictor(path))
