"""The methods that the exam compares, each asked the same of the same recordings."""

from collections.abc import Sequence

from models.ball.simulator import Simulator
from models.exam.answer import Finding, Found, Method, shots_of
from models.exam.design.trial import Recording
from models.exam.methods.identification import identification
from models.exam.methods.sindy import sindy, sindy_ensemble
from models.exam.names import name_of
from models.gap.amend.simulator import amended
from models.gap.diagnose import diagnose
from models.gap.hypotheses import Hypothesis
from models.gap.verdict import Cause

__all__ = ["METHODS", "Finding", "Found", "Method"]


def rallygap(
    recordings: Sequence[Recording], nominal: Simulator, withheld: tuple[str, ...]
) -> Finding:
    """Find causes by the gap workflow."""
    verdict = diagnose(shots_of(recordings), nominal, withheld=withheld)
    causes = tuple(_found(cause) for cause in verdict.causes)
    return Finding(verdict.verdict, causes, amended(nominal, verdict))


def _found(cause: Cause) -> Found:
    names = dict.fromkeys(name_of(Hypothesis.from_identity(one)) for one in cause.possible)
    return Found(
        name_of(cause.hypothesis),
        cause.effect,
        cause.parameter,
        cause.estimate,
        cause.interval,
        tuple(names),
    )


METHODS: dict[str, Method] = {
    "rallygap": rallygap,
    "sindy": sindy,
    "sindy_ensemble": sindy_ensemble,
    "identification": identification,
}
