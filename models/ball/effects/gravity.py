"""Gravity: the ball falls."""

from rallygap.models.ball.effect import Effect, Parameter

effect = Effect(
    name="gravity",
    title="the ball falls",
    equation="a = -g ez",
    acts="flight",
    parameters=(
        Parameter(
            "g",
            unit="m/s^2",
            bounds=(0.0, 30.0),
            observed="9.78-9.83 over the earth",
            source="Nakashima 2010",
        ),
    ),
)


@effect.adds("gravity")
def gravity(g: float) -> float:
    return g
