"""The frame is not level: gravity does not point along -z."""

import math

from rallygap.models.ball.effect import Effect, Parameter

effect = Effect(
    name="frame_tilt",
    title="the frame is not level",
    equation="gravity along (sin tx, sin ty, -sqrt(1 - sin^2 tx - sin^2 ty))",
    acts="flight",
    parameters=tuple(
        Parameter(axis, unit="rad", bounds=(-0.2, 0.2), observed="0.1-1 degree") for axis in "xy"
    ),
)


@effect.adds("gravity_tilt")
def gravity_tilt(x: float, y: float) -> tuple[float, float]:
    return (math.sin(x), math.sin(y))
