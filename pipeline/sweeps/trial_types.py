"""What a trial is to a worker: parameters in, a score out, and somebody who watches."""

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from pipeline.params import Params

Watch = Callable[[int, float], None]
"""Is told the score after every epoch or leg, and ends a trial that lags behind."""


class Trials(Protocol):
    """What trials train, and what they need for that in memory."""

    def score(self, params: Params, folder: Path, watch: Watch) -> float:
        """Train with some parameters, in a folder of its own; return the final score."""
        ...
