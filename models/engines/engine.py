"""The engine protocol: from states of balls to their states at later times."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats

Flies = Callable[[Floats, Floats], Floats]
"""From (B, 9) states and (T,) times in s, rising, the first at least zero, to (B, T, 9) states:
position (m), velocity (m/s) and spin (rad/s) in the table frame (``models/ball/state.py``)."""


class EngineError(ValueError):
    """An engine cannot fly balls, or returns what no flight can be."""


class Engine(Protocol):
    """What flies balls; each ball flies as if the others were not there."""

    @property
    def name(self) -> str:
        """Name of the engine, for reports."""
        ...

    def fly(self, states: Floats, times: Floats) -> Floats:
        """Fly balls.

        Args:
            states: (B, 9) at time zero, in the table frame.
            times: (T,) s, rising, the first one zero or later.

        Returns:
            (B, T, 9) states.

        Raises:
            EngineError: the engine fails.
        """
        ...


@dataclass(frozen=True)
class EffectsEngine:
    """A simulator that is a list of effects, as an engine."""

    name: str
    simulator: Simulator

    def fly(self, states: Floats, times: Floats) -> Floats:
        """Fly balls."""
        return self.simulator.fly(states, times).states


@dataclass(frozen=True)
class FunctionEngine:
    """A function as an engine; what it returns is checked.

    Attributes:
        name: of the function.
        function: that flies balls.
    """

    name: str
    function: Flies

    def fly(self, states: Floats, times: Floats) -> Floats:
        """Fly balls.

        Raises:
            EngineError: the function raises, or returns another shape or numbers that are not
                finite.
        """
        try:
            returned = self.function(states.copy(), times.copy())
        except Exception as error:  # of whatever kind: the code is the user's
            problem = f"raises {type(error).__name__}: {error}"
            raise EngineError(f"{self.name} {problem}") from error
        shape = (len(states), len(times), STATE_SIZE)
        try:
            flown = np.asarray(returned, dtype=np.float64)
        except (TypeError, ValueError):
            raise EngineError(f"{self.name} returns no numbers: {returned!r:.80}") from None
        if flown.shape != shape:
            raise EngineError(f"{self.name} returns the shape {flown.shape}; give {shape}")
        bad = ~np.isfinite(flown).all(axis=(1, 2))
        if bad.any():
            number = int(np.flatnonzero(bad)[0])
            raise EngineError(f"{self.name} returns numbers that are not finite, of ball {number}")
        return flown


def check_deterministic(engine: Engine, states: Floats, times: Floats) -> None:
    """Fly balls twice, the second time in reversed order.

    Raises:
        EngineError: the flights differ, so they depend on something else than the states.
    """
    first, second = engine.fly(states, times), engine.fly(states[::-1], times)[::-1]
    difference = float(np.abs(first - second).max())
    if difference > 0.0:
        problem = f"gives other flights from the same states (by up to {difference:.2g})"
        raise EngineError(f"{engine.name} {problem}; fix its seed, and keep nothing between calls")
