"""Compiled networks: a trained predictor of one ball at a time, run by ONNX Runtime.

Most of the time that torch takes for one window is its overhead for each of some hundred
operations. The network, its normaliser and the spread of its errors are compiled into one graph.
The baseline of a hybrid is an input, which comes from a simulator.

Of large networks the time is that of their matrices. Most of these are multiplied as 8-bit integers
(dynamic quantisation), which changes forecasts by less than a millimetre. Those of the output would
change them more and stay as they are. What depends on no input, such as what the first layer of a
decoder makes of the placeholders of future states, is calculated once, without integers.
"""

import ast
import logging
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from rallygap.models.predictors.learned import ForecastNetwork, LearnedPredictor
from rallygap.models.predictors.protocol import (
    FUTURE,
    FUTURE_TIMES,
    HISTORY,
    TICK,
    Floats,
    Forecast,
    History,
)
from rallygap.models.predictors.spread import Spread
from rallygap.models.predictors.transformer import Transformer

OPSET = 23  # the first with an operator for attention
SLOWER = ["MatMulAddFusion", "SkipLayerNormFusion"]  # for the few rows of one window
LARGE = 2_000_000  # parameters of a network, from which integers are faster
EXACT = {"spread", "network.network.projection"}  # modules whose matrices stay as they are
SCOPES = "pkg.torch.onnx.name_scopes"  # where the exporter notes an operator's modules


class CompiledPredictor:
    """A learned predictor of one ball; forecasts agree with torch's to rounding errors.

    Args:
        predictor: with the spread of its errors.
        horizons: the shortest and the longest that are read, s. A transformer then calculates the
            states between them alone, and others are NaN.

    Raises:
        ValueError: the predictor has no spread.
    """

    def __init__(
        self, predictor: LearnedPredictor, horizons: tuple[float, float] = (0.0, FUTURE_TIMES[-1])
    ) -> None:
        if predictor.spread is None:
            raise ValueError("this predictor has no spread, so it does not know its errors")
        network = deepcopy(predictor.network)
        if isinstance(network.network, Transformer):
            network.network.read_only(_states(horizons))
        self._baseline = network.physics
        model = _exported(_Graph(network, predictor.spread).eval())
        self._session = _run_by(_quantised(model) if network.parameter_count > LARGE else model)

    def predict(self, history: History) -> Forecast:
        """Forecast one ball."""
        return self.predict_with_covariances(history)[0]

    def predict_with_covariances(self, history: History) -> tuple[Forecast, Floats]:
        """Forecast one ball, with (1, 60, 3, 3) covariances of positions, m^2."""
        feeds = {"history": history.states.astype(np.float32), "mask": history.mask}
        if self._baseline is not None:
            feeds["motion"] = self._baseline.predict(history).states.astype(np.float32)
        states, covariances = (part.astype(np.float64) for part in self._session.run(None, feeds))
        return Forecast(states, history.spin_measured), covariances


def _states(horizons: tuple[float, float]) -> slice:
    """Return the future states between two horizons, and those on either side.

    Times are interpolated between two states, and differ from a state's by rounding.
    """
    first, last = (round(horizon / TICK) for horizon in horizons)
    return slice(max(first - 2, 0), min(last + 1, FUTURE))


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


def _run_by(model: Any, **settings: Any) -> Any:
    """Return a session that runs a model on the thread that calls it, with settings of options."""
    import onnxruntime as runtime

    options = runtime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    for name, value in settings.items():
        setattr(options, name, value)
    return runtime.InferenceSession(
        model.SerializeToString(),
        options,
        providers=["CPUExecutionProvider"],
        disabled_optimizers=SLOWER,
    )


def _exported(graph: _Graph) -> Any:
    """Return a graph as an ONNX model."""
    example = {
        "history": torch.zeros(1, HISTORY, 6),
        "mask": torch.ones(1, HISTORY, 6, dtype=torch.bool),
    }
    if graph.network.physics is not None:
        example["motion"] = torch.zeros(1, FUTURE, 9)
    with _silent():
        exported = torch.onnx.export(
            graph,
            tuple(example.values()),
            dynamo=True,
            verbose=False,
            input_names=list(example),
            opset_version=OPSET,
        )
    assert exported is not None  # only when a file is given
    return exported.model_proto


def _quantised(model: Any) -> Any:
    """Return an ONNX model that multiplies most of its matrices as integers.

    Before that, what depends on no input becomes a constant, by way of a file.
    """
    import onnx
    from onnxruntime import GraphOptimizationLevel
    from onnxruntime.quantization import QuantType, quantize_dynamic

    exact = []
    for node in model.graph.node:
        notes = {note.key: note.value for note in node.metadata_props}
        if EXACT & set(ast.literal_eval(notes.get(SCOPES, "[]"))):
            exact.append(node.name)
    with _silent(), tempfile.TemporaryDirectory() as folder:
        constants, path = Path(folder) / "constants.onnx", Path(folder) / "quantised.onnx"
        level = GraphOptimizationLevel.ORT_ENABLE_BASIC
        _run_by(model, graph_optimization_level=level, optimized_model_filepath=str(constants))
        quantize_dynamic(
            onnx.load(constants),
            path,
            op_types_to_quantize=["MatMul", "Gemm"],
            nodes_to_exclude=exact,
            weight_type=QuantType.QInt8,
            # Of 7 bits: products of 8 overflow on processors without VNNI, an error of 6 mm.
            reduce_range=True,
            extra_options={"MatMulConstBOnly": True},
        )
        return onnx.load(path)


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
