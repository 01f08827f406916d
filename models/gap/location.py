"""Located: what is known of where a gap arises."""

from dataclasses import dataclass

from models.ball.types import Floats, Integers
from models.gap.types import PHASES, Phase


@dataclass(frozen=True)
class Growth:
    """The parting against one axis, in K bins.

    Attributes:
        axis: its name.
        unit: of its values, empty for kinds.
        centres: (K,) medians of the axis in the bins, or numbers.
        kinds: (K,) names of the bins where they are kinds.
        means: (K, 3) m along the course, across it (to the right) and up.
        errors: (K, 3) m, half the 95 % interval of a mean.
        counts: (K,) shots.
        share: of the partings' variance that goes with the axis; of the time since launch, share
            of the mean square that all shots have in common.
        p_value: chance that any axis is as telling where none tells anything.
    """

    axis: str
    unit: str
    centres: Floats
    kinds: tuple[str, ...]
    means: Floats
    errors: Floats
    counts: Integers
    share: float
    p_value: float


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
    discrepancy: Floats
    shares: dict[Phase, Floats]
    time: Growth
    growth: tuple[Growth, ...]
    trend_horizon: float

    @property
    def where(self) -> dict[Phase, float]:
        """The phases' shares over all horizons, by how far balls part; zero where they do not."""
        whole = max(float(self.discrepancy.sum()), 1e-12)
        return {phase: float(self.discrepancy @ self.shares[phase]) / whole for phase in PHASES}
