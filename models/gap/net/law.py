"""The law of the net: its maximum-likelihood restitution and friction.

Measured velocities just after an impact, less those of the law, have a Student distribution: the
net gives way in another manner each time. Its size is a share of the speed towards the net, free
like the law's values, and each impact's velocities have their own errors.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq, minimize, minimize_scalar
from scipy.stats import chi2

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.net.impacts import Impacts
from rallygap.models.gap.settings import GapSettings

PARAMETERS = (Hypothesis("net", "restitution"), Hypothesis("net", "friction"))
SPREADS = (1e-3, 2.0)  # bounds of the scatter, as a share of the speed towards the net
STARTS = ((0.1, 0.3), (0.4, 0.3), (0.1, 1.0), (0.4, 1.0))  # of restitution and friction


@dataclass(frozen=True)
class NetLaw:
    """Likelihood of the net's restitution and friction.

    Attributes:
        impacts: measured.
        simulator: that explains the flights.
        settings: of the workflow.
    """

    impacts: Impacts
    simulator: Simulator
    settings: GapSettings

    def with_values(self, values: Floats) -> Simulator:
        """Return the simulator with (2,) restitution and friction of the net."""
        restitution, friction = (float(value) for value in values)
        return self.simulator.amended("net", restitution=restitution, friction=friction)

    @cached_property
    def estimate(self) -> Floats:
        """(2,) the maximum-likelihood restitution and friction."""
        found = [self._minimised(self.deviance_at, np.array(start)) for start in STARTS]
        return min(found, key=lambda one: one[1])[0]

    @property
    def amended(self) -> Simulator:
        """The simulator with the estimate."""
        return self.with_values(self.estimate)

    @cached_property
    def deviance(self) -> float:
        """Twice the negative log likelihood of the estimate."""
        return self.deviance_at(self.estimate)

    def deviance_at(self, values: Floats) -> float:
        """Return twice the negative log likelihood of (2,) values."""
        return self.deviance_of(self.with_values(values))

    def deviance_of(self, simulator: Simulator) -> float:
        """Return twice the negative log likelihood of a simulator's net, or of none."""
        misses = self.impacts.after - self.impacts.velocities(simulator)
        squares = (misses**2).sum(axis=1)
        degrees, axes = self.settings.net.degrees, misses.shape[1]

        def of_spread(logarithm: float) -> float:
            spread = (np.exp(logarithm) * self.impacts.speeds) ** 2 + self.impacts.variances
            tails = (degrees + axes) * np.log1p(squares / spread / degrees)
            return float((axes * np.log(spread) + tails).sum())

        bounds = float(np.log(SPREADS[0])), float(np.log(SPREADS[1]))
        return float(minimize_scalar(of_spread, bounds=bounds, method="bounded").fun)

    def interval(self, k: int) -> tuple[float, float]:
        """Return the interval of one of the two values (profile likelihood)."""
        low, high = PARAMETERS[k].declaration.bounds
        limit = self.deviance + float(chi2.ppf(self.settings.confidence, 1))

        def excess(value: float) -> float:
            def of_other(other: Floats) -> float:
                return self.deviance_at(np.insert(other, k, value))

            start = np.delete(self.estimate, k)
            bounds = PARAMETERS[1 - k].declaration.bounds
            return self._minimised(of_other, start, (bounds,))[1] - limit

        return self._crossing(excess, k, low), self._crossing(excess, k, high)

    def _crossing(self, excess: Callable[[float], float], k: int, end: float) -> float:
        """Return where a deviance crosses its limit between the estimate and an end."""
        value = float(self.estimate[k])
        if value == end or excess(end) <= 0.0:
            return end
        return float(brentq(excess, value, end, xtol=1e-3))

    def _minimised(
        self,
        deviance: Callable[[Floats], float],
        start: Floats,
        bounds: tuple[tuple[float, float], ...] | None = None,
    ) -> tuple[Floats, float]:
        limits = bounds or tuple(one.declaration.bounds for one in PARAMETERS)
        found = minimize(
            deviance,
            start,
            method="Nelder-Mead",
            bounds=limits,
            options={"xatol": 1e-3, "fatol": 1e-2},
        )
        return np.asarray(found.x), float(found.fun)
