"""A steady side force, as on a knuckle ball."""

import math

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Air
from rallygap.models.ball.state import DRAG_FACTOR
from rallygap.models.ball.types import Vector

effect = Effect(
    name="side_force",
    title="a steady side force",
    equation="a = rho A C_Y / 2m |u|^2, horizontal, to the right of the path",
    acts="flight",
    parameters=(Parameter("cy", bounds=(-0.5, 0.5), observed="to 0.05 on a knuckle ball"),),
)


@effect.adds("specific_force")
def specific_force(air: Air, cy: float) -> Vector:
    ux, uy, _ = air.velocity
    along = math.sqrt(ux * ux + uy * uy)
    if cy == 0.0 or along == 0.0:  # absent, or straight up or down: no right hand side
        return (0.0, 0.0, 0.0)
    push = DRAG_FACTOR * cy * air.speed * air.speed / along
    return (push * uy, -push * ux, 0.0)
