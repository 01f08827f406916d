"""The gap's shares by phase, labels with the wrong sign among them."""

from models.gap.location import Located
from models.gap.types import PHASES
from models.gap.verdict import PhaseShares


def phase_shares(located: Located | None, label_signs: float) -> PhaseShares:
    """Return the shares of the phases; all zero where there is no discrepancy.

    Args:
        located: the discrepancy of trajectories; None where shots are too short.
        label_signs: share of the gap of spin labels with the wrong sign, which is the sensor's.
    """
    shares = located.phase_shares if located else dict.fromkeys(PHASES, 0.0)
    parts = {phase: (1 - label_signs) * share for phase, share in shares.items()}
    parts["sensor"] += label_signs
    total = max(sum(parts.values()), 1e-12)
    return PhaseShares(**{phase: part / total for phase, part in parts.items()})
