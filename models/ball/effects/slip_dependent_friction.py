"""Friction depends on how fast the contact point slides."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Impact

effect = Effect(
    name="slip_dependent_friction",
    title="friction depends on slip speed",
    equation="mu + c (|v_b| - 4)",
    acts="contact",
    parameters=(
        Parameter(
            "c",
            unit="s/m",
            bounds=(-0.2, 0.2),
            observed="mu rises from 0.16 to 0.20 with slip in cannon shots",
            source="fits of cannon shots",
        ),
    ),
)


@effect.adds("table_friction")
def table_friction(impact: Impact, c: float) -> float:
    return c * (impact.slip - 4.0)
