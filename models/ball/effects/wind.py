"""Wind: the air moves over the table."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.types import Vector

effect = Effect(
    name="wind",
    title="the air moves",
    equation="u = v - wind",
    acts="flight",
    parameters=tuple(
        Parameter(axis, unit="m/s", bounds=(-10.0, 10.0), observed="0.1-0.5 from air conditioning")
        for axis in "xyz"
    ),
)


@effect.adds("wind")
def wind(x: float, y: float, z: float) -> Vector:
    return (x, y, z)
