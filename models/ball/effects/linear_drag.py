"""Drag in proportion to speed: not physical for this ball, a decoy for tests."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Air
from rallygap.models.ball.types import Vector

effect = Effect(
    name="linear_drag",
    title="drag in proportion to speed (a decoy)",
    equation="a = -k1 u",
    acts="flight",
    parameters=(
        Parameter(
            "k1",
            unit="1/s",
            bounds=(-2.0, 2.0),
            observed="not physical at these Reynolds numbers",
            source="Stokes drag",
        ),
    ),
)


@effect.adds("specific_force")
def specific_force(air: Air, k1: float) -> Vector:
    ux, uy, uz = air.velocity
    return (-k1 * ux, -k1 * uy, -k1 * uz)
