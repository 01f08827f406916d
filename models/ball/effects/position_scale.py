"""The cameras' scale is off."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import View

effect = Effect(
    name="position_scale",
    title="the cameras' scale is off",
    equation="x_measured = (1 + s) x",
    acts="sensor",
    parameters=(Parameter("s", bounds=(-0.1, 0.1), observed="0.1-1 percent"),),
)


@effect.scales("position_gain")
def position_gain(view: View, s: float) -> float:
    return 1.0 + s
