"""Restitution falls with the speed of the impact."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import TYPICAL_IMPACT, Impact

effect = Effect(
    name="speed_dependent_restitution",
    title="restitution falls with impact speed",
    equation="e - c (|v_n| - 2.5)",
    acts="contact",
    parameters=(
        Parameter(
            "c",
            unit="s/m",
            bounds=(-0.1, 0.1),
            observed="0.02 at high speed, none below 4 m/s",
            source="drop and cannon tests",
        ),
    ),
)


@effect.adds("table_restitution")
def table_restitution(impact: Impact, c: float) -> float:
    return -c * (impact.normal_speed - TYPICAL_IMPACT)
