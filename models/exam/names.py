"""Names of causes in exam records: the effect, or the parameter where an effect has several."""

from models.ball.catalogue import catalogue
from models.gap.hypotheses import AXES, Hypothesis


def name_of(hypothesis: Hypothesis) -> str:
    """Return the name that a record has for a hypothesis, such as ``wind`` or ``restitution``."""
    several = len(catalogue()[hypothesis.effect].parameters) > 1
    return (
        hypothesis.parameter if several and hypothesis.parameter not in AXES else hypothesis.effect
    )
