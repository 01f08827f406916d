"""The racket: rubber stores the tangential energy and gives it back (Nakashima 2010)."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Impact
from rallygap.models.ball.state import BALL_MASS

effect = Effect(
    name="racket_bounce",
    title="the ball bounces off the racket",
    equation="v_n' = -(e - c |v_n|) v_n; alpha = k_p / m, no roll limit",
    acts="contact",
    parameters=(
        Parameter(
            "restitution",
            neutral=-1.0,
            bounds=(0.0, 1.0),
            observed="0.878",
            source="fits of racket contacts",
        ),
        Parameter(
            "speed_loss",
            unit="s/m",
            bounds=(0.0, 0.1),
            observed="0.020",
            source="fits of racket contacts",
        ),
        Parameter(
            "kp",
            unit="kg",
            bounds=(0.0, 2.16e-3),
            observed="1.9e-3, a tangential restitution of 0.76",
            source="Nakashima 2010; the 0.019 in print is ten times too large",
        ),
    ),
)


@effect.adds("racket_restitution")
def racket_restitution(impact: Impact, restitution: float, speed_loss: float, kp: float) -> float:
    return 1.0 + restitution - speed_loss * impact.normal_speed


@effect.adds("racket_grip")
def racket_grip(impact: Impact, restitution: float, speed_loss: float, kp: float) -> float:
    return kp / BALL_MASS
