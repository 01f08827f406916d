"""Restitution depends on the spin in the table's plane."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Impact

effect = Effect(
    name="spin_dependent_restitution",
    title="restitution depends on spin",
    equation="e + c (r|w_t| - 3)",
    acts="contact",
    parameters=(Parameter("c", unit="s/m", bounds=(-0.1, 0.1), observed="not reported"),),
)


@effect.adds("table_restitution")
def table_restitution(impact: Impact, c: float) -> float:
    return c * (impact.tangential_spin - 3.0)
