"""Compiled networks: a trained predictor of one ball at a time, run by ONNX Runtime.

Most of the time that torch takes for one window is its overhead for each of some hundred
operations. The network, its normaliser and the spread of its errors are compiled into one graph.
The baseline of a hybrid is an input, which comes from a simulator.
"""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from models.predictors.learned import ForecastNetwork, LearnedPredictor
from models.predictors.physics import PhysicsPredictor
from models.predictors.protocol import FUTURE, HISTORY, Floats, Forecast, History
from models.predictors.spread import Spread

OPSET = 23  # the first with an operator for attention
SLOWER = ["MatMulAddFusion", "SkipLayerNormFusion"]  # for the few rows of one window


class CompiledPredictor:
    """A learned predictor of one ball; forecasts agree with torch's to rounding errors of float32.

    Args:
        predictor: with the spread of its errors.

    Raises:
        ValueError: the predictor has no spread.
    """

    def __init__(self, predictor: LearnedPredictor) -> None:
        if predictor.spread is None:
            raise ValueError("this predictor has no spread, so it does not know its errors")
        simulator = predictor.network.simulator
        self._baseline = PhysicsPredictor(simulator) if simulator else None
        self._session = _session(_Graph(predictor.network, predictor.spread).eval())

    def predict(self, history: History) -> Forecast:
        """Forecast one ball."""
        return self.predict_with_covariances(history)[0]

    def predict_with_covariances(self, history: History) -> tuple[Forecast, Floats]:
        """Forecast one ball, with (1, 60, 3, 3) covariances of positions, m^2."""
        feeds = {"history": history.states.astype(np.float32), "mask": history.mask}
        if self._baseline is not None:
            feeds["motion"] = self._baseline.predict(history).states.astype(np.float32)
        states, covariances = (one.astype(np.float64) for one in self._session.run(None, feeds))
        return Forecast(states, history.spin_measured), covariances


class _Graph(nn.Module):
    def __init__(self, network: ForecastNetwork, spread: Spread) -> None:
        super().__init__()
        self.network, self.spread = network, spread

    def forward(
        self, history: Tensor, mask: Tensor, motion: Tensor | None = None
    ) -> tuple[Tensor, Tensor]:
        if motion is None:
            motion = self.network.baseline(history, mask)
        factors = self.network.factors(self.spread, history, mask, motion)
        return self.network.corrected(history, mask, motion), factors.mT @ factors

    @property
    def example(self) -> dict[str, Tensor]:
        """Inputs for one ball, by name."""
        mask = torch.ones(1, HISTORY, 6, dtype=torch.bool)
        given = {"history": torch.zeros(1, HISTORY, 6), "mask": mask}
        hybrid = self.network.simulator is not None
        return {**given, "motion": torch.zeros(1, FUTURE, 9)} if hybrid else given


def _session(graph: _Graph) -> Any:
    """Compile a graph; it runs on the thread that calls it."""
    import onnxruntime as runtime

    options = runtime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    return runtime.InferenceSession(
        _exported(graph),
        options,
        providers=["CPUExecutionProvider"],
        disabled_optimizers=SLOWER,
    )


def _exported(graph: _Graph) -> bytes:
    """Return a graph as an ONNX file."""
    example, names = tuple(graph.example.values()), list(graph.example)
    with _silent():
        exported = torch.onnx.export(
            graph, example, dynamo=True, verbose=False, input_names=names, opset_version=OPSET
        )
    assert exported is not None  # only when a file is given
    content: bytes = exported.model_proto.SerializeToString()
    return content


@contextmanager
def _silent() -> Iterator[None]:
    """Leave out what the exporter says of libraries that are not installed."""
    level = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(level)
