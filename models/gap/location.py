"""Where a gap arises: trajectory discrepancy over the horizon, by phase and by covariate."""

from dataclasses import dataclass

from models.ball.types import Floats
from models.gap.types import PHASES, Phase


@dataclass(frozen=True)
class Growth:
    """The discrepancy against one covariate, in K bins.

    Attributes:
        covariate: its name.
        unit: of its values, empty for categories.
        centres: (K,) medians of the covariate in the bins, or numbers of categories.
        kinds: (K,) names of the bins where they are categories.
        means: (K, 3) m along the course, across it (to the right) and up.
        margins: (K, 3) m, half the 95 % interval of a mean.
        share: of the discrepancies' variance that the covariate explains.
        p_value: probability that any covariate explains as much where none has an influence.
    """

    covariate: str
    unit: str
    centres: Floats
    kinds: tuple[str, ...]
    means: Floats
    margins: Floats
    share: float
    p_value: float


@dataclass(frozen=True)
class Located:
    """Trajectory discrepancy over the horizon, by phase and against covariates.

    Attributes:
        horizons: (H,) s after the last sample that a prediction uses.
        discrepancy: (H,) m, root mean square over shots, without noise and scatter.
        shares: (H,) of each phase in its square; zero where there is no discrepancy.
        means: (H, 3) m along the course, across it (to the right) and up, over shots.
        margins: (H, 3) m, half the 95 % interval of a mean.
        growth: its growth with every covariate, the most informative first.
        trend_horizon: s, the horizon at which ``growth`` is evaluated.
    """

    horizons: Floats
    discrepancy: Floats
    shares: dict[Phase, Floats]
    means: Floats
    margins: Floats
    growth: tuple[Growth, ...]
    trend_horizon: float

    @property
    def phase_shares(self) -> dict[Phase, float]:
        """Mean shares over all horizons, weighted by the discrepancy; zero where there is none."""
        whole = max(float(self.discrepancy.sum()), 1e-12)
        return {phase: float(self.discrepancy @ self.shares[phase]) / whole for phase in PHASES}
