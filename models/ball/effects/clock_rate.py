"""The cameras' clock runs fast or slow."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import View

effect = Effect(
    name="clock_rate",
    title="the clock runs fast or slow",
    equation="t_measured = (1 + d) t",
    acts="sensor",
    parameters=(Parameter("d", bounds=(-0.2, 0.2), observed="1e-4; 1e-2 for a wrong frame rate"),),
)


@effect.scales("clock_gain")
def clock_gain(view: View, d: float) -> float:
    return 1.0 + d
