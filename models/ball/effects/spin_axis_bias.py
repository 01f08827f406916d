"""Spin labels are turned."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import View
from rallygap.models.ball.types import Vector

effect = Effect(
    name="spin_axis_bias",
    title="spin labels are turned",
    equation="w_measured = R(rotation vector) w",
    acts="sensor",
    parameters=tuple(
        Parameter(axis, unit="rad", bounds=(-0.8, 0.8), observed="1-3 degrees") for axis in "xyz"
    ),
)


@effect.adds("spin_label_rotation")
def spin_label_rotation(view: View, x: float, y: float, z: float) -> Vector:
    return (x, y, z)
