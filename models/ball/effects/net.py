"""The net: a ball that touches it loses most of its speed; one on the cord hops over."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import Impact

effect = Effect(
    name="net",
    title="the net stops the ball",
    equation="as table_bounce, along the line from the net's nearest point to the ball",
    acts="contact",
    parameters=(
        Parameter(
            "restitution",
            neutral=-1.0,
            bounds=(0.0, 1.0),
            observed="not reported; a net gives way",
            source="assumption: 0.2",
        ),
        Parameter("friction", bounds=(0.0, 2.0), observed="not reported", source="assumption: 0.5"),
    ),
)


@effect.adds("net_restitution")
def net_restitution(impact: Impact, restitution: float, friction: float) -> float:
    return 1.0 + restitution


@effect.adds("net_friction")
def net_friction(impact: Impact, restitution: float, friction: float) -> float:
    return friction
