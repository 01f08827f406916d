"""Lift crisis: above 11 m/s the lift near S = 0.5 drops, even below zero."""

import math

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Air

effect = Effect(
    name="lift_crisis",
    title="lift breaks down above 11 m/s",
    equation="C_M (1 - d exp(-((S - 0.5) / 0.15)^2 / 2) / (1 + exp(-(|u| - 11) / 0.4)))",
    acts="flight",
    parameters=(
        Parameter(
            "d",
            bounds=(0.0, 3.0),
            observed="to zero or negative lift above 11 m/s",
            source="after Miyazaki 2017",
        ),
    ),
)


@effect.scales("magnus_coefficient")
def magnus_coefficient(air: Air, d: float) -> float:
    if d == 0.0:  # two exponentials saved in the hot path
        return 1.0
    dip = math.exp(-(((air.spin_ratio - 0.5) / 0.15) ** 2) / 2.0)
    return 1.0 - d * dip / (1.0 + math.exp(-(air.speed - 11.0) / 0.4))
