"""First causes: those that hide all others, so that they are in the fit that naming starts from.

Lift where a simulator has none and spins bend paths (missing_lift.py). And the bounce where a
simulator's table hardly lets balls rise, as MuJoCo's default contact: balls that bounce again and
again, or stay on the table, say nothing about shots after their bounce.
"""

from models.gap.fit.refit import RefitResult, refit
from models.gap.fit.shots import Shots
from models.gap.hypotheses import Hypothesis, hypotheses
from models.gap.name.missing_lift import lift_test
from models.gap.settings import Question

LIFT = Hypothesis("magnus", "cm")
RESTITUTION = Hypothesis("table_bounce", "restitution")
FRICTION = Hypothesis("table_bounce", "friction")
FIRST_CAUSES = (LIFT, RESTITUTION)


def about_first_causes(shots: Shots, question: Question) -> RefitResult | None:
    """Return the shots refitted with a cause that hides all others; None without such a cause."""
    return _with_bounce(shots, question) or _with_lift(shots, question)


def _with_bounce(shots: Shots, question: Question) -> RefitResult | None:
    """Return the shots with the bounce of a real table, if the simulator's is dead.

    Friction is free as well: a ball that rolls after every contact does not tell how large it is.
    """
    simulator, settings = question.simulator, question.settings
    if not RESTITUTION.listed(simulator) or RESTITUTION.effect in question.withheld:
        return None
    if RESTITUTION.value(simulator) > settings.name.dead_restitution:
        return None
    restitution, friction = settings.name.bounce_start
    start = FRICTION.at(RESTITUTION.at(simulator, restitution), friction)
    return refit(shots, start, (RESTITUTION, FRICTION), settings.fit)


def _with_lift(shots: Shots, question: Question) -> RefitResult | None:
    """Return the shots with lift, where spins bend them and the simulator has none."""
    simulator, settings = question.simulator, question.settings
    if LIFT.effect in (*simulator.effects, *question.withheld):
        return None
    listed = tuple(one for one in hypotheses(simulator) if one.listed(simulator))
    test = lift_test(shots, refit(shots, simulator, listed, settings.fit), settings)
    if test.p_value > settings.level:
        return None
    # The listed parameters start from their nominal values again: a change must be significant.
    lifted = LIFT.at(simulator, LIFT.value(test.with_lift.simulator))
    return refit(shots, lifted, (LIFT,), settings.fit)
