"""The table is not level in the frame."""

import math

from rallygap.models.ball.effect import Effect, Parameter

effect = Effect(
    name="table_tilt",
    title="the table is not level",
    equation="surface normal along (sin tx, sin ty, 1)",
    acts="contact",
    parameters=tuple(
        Parameter(axis, unit="rad", bounds=(-0.1, 0.1), observed="0.05-0.3 degrees")
        for axis in "xy"
    ),
)


@effect.adds("table_tilt")
def table_tilt(x: float, y: float) -> tuple[float, float]:
    return (math.sin(x), math.sin(y))
