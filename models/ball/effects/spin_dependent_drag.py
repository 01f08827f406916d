"""The drag coefficient grows with the spin ratio."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import TYPICAL_SPIN_RATIO, Air

effect = Effect(
    name="spin_dependent_drag",
    title="the drag coefficient grows with spin",
    equation="C_D + c (S - 0.5)",
    acts="flight",
    parameters=(
        Parameter(
            "c",
            bounds=(-0.5, 0.5),
            observed="0.05-0.1",
            source="wind-tunnel data on spinning spheres",
        ),
    ),
)


@effect.adds("drag_coefficient")
def drag_coefficient(air: Air, c: float) -> float:
    return c * (air.spin_ratio - TYPICAL_SPIN_RATIO)
