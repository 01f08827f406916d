"""Located: what is known of where a gap arises."""

from dataclasses import dataclass

from models.ball.types import Floats
from models.gap.locate.trends import Growth
from models.gap.name.unexplained import PHASES, Phase


@dataclass(frozen=True)
class Located:
    """How far balls part, where that arises, and against what it grows.

    Attributes:
        horizons: (H,) s after the last sample that a prediction sees.
        parting: (H,) m, root mean square over shots, without noise and scatter.
        shares: (H,) of each phase in its square; zero where nothing parts.
        time: how it grows with the time since launch.
        growth: how it grows with every other axis, the most telling first.
        looked_at: s, the horizon at which those are looked at.
    """

    horizons: Floats
    parting: Floats
    shares: dict[Phase, Floats]
    time: Growth
    growth: tuple[Growth, ...]
    looked_at: float

    @property
    def where(self) -> dict[Phase, float]:
        """The phases' shares over all horizons, by how far balls part; zero where they do not."""
        whole = max(float(self.parting.sum()), 1e-12)
        return {phase: float(self.parting @ self.shares[phase]) / whole for phase in PHASES}
