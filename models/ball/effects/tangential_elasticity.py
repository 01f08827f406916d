"""The table gives tangential energy back: the roll limit rises."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Impact

effect = Effect(
    name="tangential_elasticity",
    title="the table gives tangential energy back",
    equation="alpha <= 2/5 (1 + e_t)",
    acts="contact",
    parameters=(
        Parameter(
            "et", bounds=(0.0, 1.0), observed="0 on wood", source="Maw, Barber, Fawcett 1976"
        ),
    ),
)


@effect.adds("table_elasticity")
def table_elasticity(impact: Impact, et: float) -> float:
    return et
