"""A trained predictor as MLflow loads and serves it: arrays by name in, arrays by name out.

``mlflow.pyfunc`` imports this module and hands it the folder that the stage wrote: weights as
safetensors, the rest as JSON. Nothing in a logged model is pickled, so none runs code.
"""

from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from rallygap.models.predictors.learned import LearnedPredictor
from rallygap.models.predictors.protocol import History
from rallygap.pipeline.predictors.storage import load_predictor


class LoggedPredictor:
    """A predictor behind MLflow's interface; see ``model_registry.py`` for its signature."""

    def __init__(self, predictor: LearnedPredictor) -> None:
        self.predictor = predictor

    def predict(
        self, inputs: dict[str, NDArray[Any]], params: dict[str, Any] | None = None
    ) -> dict[str, NDArray[Any]]:
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


def _load_pyfunc(folder: str) -> LoggedPredictor:
    """Load the predictor of a folder: the name that MLflow calls."""
    return LoggedPredictor(load_predictor(Path(folder)))
