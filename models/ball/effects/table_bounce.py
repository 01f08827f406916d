"""The table: the ball bounces, slides or rolls (Nakashima 2010, 2011)."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Impact

effect = Effect(
    name="table_bounce",
    title="the ball bounces off the table",
    equation="v_n' = -e v_n; alpha = min(mu (1 + e) |v_n| / |v_b|, 2/5)",
    acts="contact",
    parameters=(
        Parameter(
            "restitution",
            neutral=-1.0,
            bounds=(0.0, 1.0),
            observed="0.866-0.960",
            source="Nakashima 2010: 0.93",
        ),
        Parameter(
            "friction", bounds=(0.0, 2.0), observed="0.15-0.35", source="Nakashima 2010: 0.25"
        ),
    ),
)


@effect.adds("table_restitution")
def table_restitution(impact: Impact, restitution: float, friction: float) -> float:
    return 1.0 + restitution


@effect.adds("table_friction")
def table_friction(impact: Impact, restitution: float, friction: float) -> float:
    return friction
