"""The removable gap: the distance between simulated and true trajectories, all else equal.

New launches that no recording contains are rolled out without scatter from their true states. Their
noise-free measurements are compared with those that a simulator predicts from the same launches.
The floor is zero: a perfect simulator leaves nothing. The gap is the root mean square distance over
the balls, averaged over the horizons. It is linear in the size of an error, so an estimate that is
5 % off leaves 5 % of the gap.
"""

import numpy as np

from rallygap.models.arena.bounce_scatter import BounceScatter
from rallygap.models.ball.sensor import measured
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.exam.simulate.launches import Launches, launches
from rallygap.models.exam.simulate.recordings import MARGIN, SealedTruth
from rallygap.models.exam.simulate.scattered_shots import scattered_shots

BALLS = 100
HORIZONS = np.arange(0.1, 0.65, 0.1)  # s after the launch; the bounce is at 0.2 to 0.4 s
HELD_OUT = 5  # stream of random numbers; the recordings use 0 to 4


class RemovableGap:
    """The gap between simulators and the environment of one trial, on held-out launches."""

    def __init__(self, truth: SealedTruth) -> None:
        trial = truth.trial
        random = np.random.default_rng([trial.seed, HELD_OUT])
        self._drawn: Launches = launches(trial.base, BALLS, trial.directions, random)
        shots = scattered_shots(
            truth.shots.ball,
            trial.simulator,
            self._drawn.states,
            np.maximum(self._drawn.durations, HORIZONS[-1]) + MARGIN,
            BounceScatter(restitution=0.0, friction=0.0),
            random,
        )
        self._true = self._positions(shots)

    def remaining(self, simulator: Simulator) -> float:
        """Return the gap between a simulator and the environment in mm."""
        return self._distance(self._positions(simulator), self._true)

    def between(self, first: Simulator, second: Simulator) -> float:
        """Return the gap between two simulators in mm."""
        return self._distance(self._positions(first), self._positions(second))

    def _distance(self, positions: Floats, others: Floats) -> float:
        squared = ((positions - others) ** 2).sum(axis=2)
        flying = self._drawn.durations[:, None] >= HORIZONS
        mean = (squared * flying).sum(axis=0) / np.maximum(flying.sum(axis=0), 1)
        return 1000.0 * float(np.sqrt(mean).mean())

    def _positions(self, simulator: Simulator) -> Floats:
        # Draws only the flipped spin labels, which do not change positions.
        unused = np.random.default_rng(0)
        positions, _ = measured(simulator, self._drawn.states, HORIZONS, unused)
        return positions
