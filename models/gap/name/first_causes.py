"""First causes: those that hide all others, so that they are in the fit that naming starts from.

Lift where a simulator has none and spins bend paths (missing_lift.py). And the bounce where a
simulator's table hardly lets balls rise, as MuJoCo's default contact: balls that bounce again and
again, or stay on the table, say nothing about shots after their bounce.
"""

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.fit.refit import RefitResult, refit
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.hypotheses import Hypothesis, hypotheses
from rallygap.models.gap.name.missing_lift import lift_test
from rallygap.models.gap.settings import Question

LIFT = Hypothesis("magnus", "cm")
RESTITUTION = Hypothesis("table_bounce", "restitution")
FRICTION = Hypothesis("table_bounce", "friction")
FIRST_CAUSES = (LIFT, RESTITUTION)


def about_first_causes(shots: Shots, question: Question, base: RefitResult) -> RefitResult:
    """Return the shots refitted with the causes that hide all others; the base without such causes.

    Args:
        shots: measured.
        question: whose simulator may lack these causes.
        base: the shots about this simulator.
    """
    simulator, causes = _with_bounce(question)
    if (lifted := _with_lift(shots, simulator, question)) is not None:
        simulator, causes = lifted, (*causes, LIFT)
    return refit(shots, simulator, causes, question.settings.fit) if causes else base


def _with_bounce(question: Question) -> tuple[Simulator, tuple[Hypothesis, ...]]:
    """Return the simulator with the bounce of a real table, if its own is dead, and what is free.

    Friction is free as well: a ball that rolls after every contact does not tell how large it is.
    """
    simulator, settings = question.simulator, question.settings.name
    if not RESTITUTION.listed(simulator) or RESTITUTION.effect in question.withheld:
        return simulator, ()
    if RESTITUTION.value(simulator) > settings.dead_restitution:
        return simulator, ()
    restitution, friction = settings.bounce_start
    bouncing = FRICTION.at(RESTITUTION.at(simulator, restitution), friction)
    return bouncing, (RESTITUTION, FRICTION)


def _with_lift(shots: Shots, simulator: Simulator, question: Question) -> Simulator | None:
    """Return the simulator with lift, if spins bend the shots and it has none; else None."""
    settings = question.settings
    if LIFT.effect in (*simulator.effects, *question.withheld):
        return None
    listed = tuple(one for one in hypotheses(simulator) if one.listed(simulator))
    test = lift_test(shots, refit(shots, simulator, listed, settings.fit), settings)
    if test.p_value > settings.level:
        return None
    # The listed parameters start from their nominal values again: a change must be significant.
    return LIFT.at(simulator, LIFT.value(test.with_lift.simulator))
