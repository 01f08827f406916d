"""Spin labels are too large or too small."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import View

effect = Effect(
    name="spin_gain",
    title="spin labels are scaled",
    equation="w_measured = (1 + s) w",
    acts="sensor",
    parameters=(Parameter("s", bounds=(-0.5, 0.5), observed="5 percent"),),
)


@effect.scales("spin_label_gain")
def spin_label_gain(view: View, s: float) -> float:
    return 1.0 + s
