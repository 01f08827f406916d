"""Buoyancy: the displaced air carries part of the ball."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.state import MAGNUS_FACTOR

effect = Effect(
    name="buoyancy",
    title="the displaced air carries the ball",
    equation="g (1 - b rho V / m)",
    acts="flight",
    parameters=(
        Parameter(
            "b",
            bounds=(-5.0, 5.0),
            observed="physically 1, that is 1.5 percent of g",
            source="Archimedes",
        ),
    ),
)


@effect.scales("gravity")
def gravity(b: float) -> float:
    return 1.0 - b * MAGNUS_FACTOR
