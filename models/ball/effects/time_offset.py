"""Every measurement is late by the same time; the ball alone cannot show it."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import View

effect = Effect(
    name="time_offset",
    title="measurements are late",
    equation="x_measured(t) = x(t - tau)",
    acts="sensor",
    parameters=(
        Parameter("tau", unit="s", bounds=(-0.1, 0.1), observed="not visible in the ball's path"),
    ),
)


@effect.adds("delay")
def delay(view: View, tau: float) -> float:
    return tau
