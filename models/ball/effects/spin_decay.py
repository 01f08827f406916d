"""Spin decays in flight."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Air

effect = Effect(
    name="spin_decay",
    title="spin decays in flight",
    equation="dw/dt = -c |u| w",
    acts="flight",
    parameters=(
        Parameter(
            "c",
            unit="1/m",
            bounds=(0.0, 0.2),
            observed="about 0.004",
            source="skin friction of a rotating sphere",
        ),
    ),
)


@effect.adds("spin_damping")
def spin_damping(air: Air, c: float) -> float:
    return c
