"""Drag: the air slows the ball."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Air

effect = Effect(
    name="drag",
    title="the air slows the ball",
    equation="a = -rho A C_D / 2m |u| u",
    acts="flight",
    parameters=(
        Parameter("cd", bounds=(0.0, 1.5), observed="0.40-0.56", source="Nakashima 2010: 0.54"),
    ),
)


@effect.adds("drag_coefficient")
def drag_coefficient(air: Air, cd: float) -> float:
    return cd
