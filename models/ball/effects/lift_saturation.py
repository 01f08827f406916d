"""Lift saturates: more spin bends the path less than in proportion.

C_M stays the coefficient at a typical spin ratio, so a saturation cannot stand in for a wrong C_M.
"""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import TYPICAL_SPIN_RATIO, Air

effect = Effect(
    name="lift_saturation",
    title="lift saturates at high spin",
    equation="C_M (1 + kappa / 2) / (1 + kappa S)",
    acts="flight",
    parameters=(
        Parameter(
            "kappa",
            bounds=(0.0, 50.0),
            observed="C_L about 0.35 S / (0.20 + S), so kappa about 5 and C_M about 0.19",
            source="fits of cannon shots over S 0.15-1.2",
        ),
    ),
)


@effect.scales("magnus_coefficient")
def magnus_coefficient(air: Air, kappa: float) -> float:
    if kappa == 0.0:  # a division saved in the hot path
        return 1.0
    return (1.0 + kappa * TYPICAL_SPIN_RATIO) / (1.0 + kappa * air.spin_ratio)
