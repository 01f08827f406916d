"""Some shots carry the negated spin label."""

from rallygap.models.ball.effect import Effect, Parameter
from rallygap.models.ball.quantities import View

effect = Effect(
    name="spin_sign_flip",
    title="some spin labels are negated",
    equation="w_measured = -w in a share of the shots",
    acts="sensor",
    parameters=(Parameter("share", bounds=(0.0, 1.0), observed="14 percent in one public set"),),
)


@effect.adds("spin_flip_share")
def spin_flip_share(view: View, share: float) -> float:
    return share
