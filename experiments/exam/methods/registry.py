"""The methods that the exam compares: the gap workflow and its peers."""

from collections.abc import Sequence

from experiments.exam.interface import Answer, Method, NamedCause, Recording, shots_of
from experiments.exam.methods.evidence import evidence_greedy
from experiments.exam.methods.identification import identification
from experiments.exam.methods.sindy import sindy, sindy_ensemble
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.diagnose import diagnose

RALLYGAP = "rallygap"  # the method that the exam is for


def rallygap(
    recordings: Sequence[Recording], nominal: Simulator, withheld: tuple[str, ...]
) -> Answer:
    """Name causes by the gap workflow."""
    verdict = diagnose(shots_of(recordings), nominal, withheld=withheld)
    fields = set(NamedCause.model_fields)
    causes = tuple(NamedCause(**cause.model_dump(include=fields)) for cause in verdict.causes)
    return Answer(verdict.verdict, causes, amended(nominal, verdict))


METHODS: dict[str, Method] = {
    RALLYGAP: rallygap,
    "sindy": sindy,
    "sindy_ensemble": sindy_ensemble,
    "evidence_greedy": evidence_greedy,
    "identification": identification,
}
