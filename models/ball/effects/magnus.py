"""Magnus force: spin bends the path."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Air

effect = Effect(
    name="magnus",
    title="spin bends the path",
    equation="a = rho V C_M / m (w x u)",
    acts="flight",
    parameters=(
        Parameter(
            "cm",
            bounds=(-1.0, 1.0),
            observed="pooled fits 0.07-0.12; 0.09-0.33 where lift is not saturated",
            source="Nakashima 2010: 0.069",
        ),
    ),
)


@effect.adds("magnus_coefficient")
def magnus_coefficient(air: Air, cm: float) -> float:
    return cm
