"""The drag coefficient changes with speed."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Air

effect = Effect(
    name="speed_dependent_drag",
    title="the drag coefficient changes with speed",
    equation="C_D + c (|u| - 8) / 5",
    acts="flight",
    parameters=(
        Parameter(
            "c",
            bounds=(-0.5, 0.5),
            observed="about -0.06",
            source="fits of cannon shots; the drag crisis of smooth spheres",
        ),
    ),
)


@effect.adds("drag_coefficient")
def drag_coefficient(air: Air, c: float) -> float:
    return c * (air.speed - 8.0) / 5.0
