"""Added mass: the ball accelerates some air with it."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Air
from rallygap.models.ball.state import MAGNUS_FACTOR

effect = Effect(
    name="added_mass",
    title="the ball accelerates some air with it",
    equation="a / (1 + c rho V / 2m)",
    acts="flight",
    parameters=(
        Parameter(
            "c",
            bounds=(-5.0, 5.0),
            observed="physically 1, that is 0.74 percent of every acceleration",
            source="potential flow about a sphere",
        ),
    ),
)


@effect.adds("inertia")
def inertia(air: Air, c: float) -> float:
    return c * MAGNUS_FACTOR / 2.0
