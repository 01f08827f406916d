"""Measurements lag more the faster the ball flies."""

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import View

effect = Effect(
    name="speed_dependent_latency",
    title="measurements lag with speed",
    equation="x_measured(t) = x(t - tau |v|)",
    acts="sensor",
    parameters=(
        Parameter("tau", unit="s^2/m", bounds=(-0.002, 0.002), observed="1-5 ms per 10 m/s"),
    ),
)


@effect.adds("delay")
def delay(view: View, tau: float) -> float | NDArray[np.float64]:
    return tau * view.speed
