"""Where a gap arises: trajectory discrepancy over the horizon, by phase and by covariate."""

from dataclasses import dataclass

from rallygap.models.ball.types import Floats
from rallygap.models.gap.types import PHASES, Phase


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
        of_causes: (H,) of each cause, by identity; under an empty name that of no cause.
        means: (H, 3) m along the course, across it (to the right) and up, over shots.
        margins: (H, 3) m, half the 95 % interval of a mean.
        growth: its growth with every covariate, the most informative first.
        trend_horizon: s, the horizon at which ``growth`` is evaluated.
    """

    horizons: Floats
    discrepancy: Floats
    shares: dict[Phase, Floats]
    of_causes: dict[str, Floats]
    means: Floats
    margins: Floats
    growth: tuple[Growth, ...]
    trend_horizon: float

    @property
    def phase_shares(self) -> dict[Phase, float]:
        """Mean shares of phases over all horizons, weighted by the discrepancy."""
        return {phase: self._mean(self.shares[phase]) for phase in PHASES}

    @property
    def gap_shares(self) -> dict[str, float]:
        """Mean shares of causes over all horizons, weighted by the discrepancy."""
        return {identity: self._mean(share) for identity, share in self.of_causes.items()}

    def _mean(self, share: Floats) -> float:
        return float(self.discrepancy @ share) / max(float(self.discrepancy.sum()), 1e-12)
