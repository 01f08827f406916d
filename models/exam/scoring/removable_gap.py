"""The removable gap: how far a simulator's balls part from those of a hall, everything else equal.

Fresh launches of the hall, which no recording shows, fly without scatter from their true states.
What its sensor would show of them, without noise, is compared with what a simulator says of the
same launches. So a perfect simulator leaves nothing: the floor is zero, and the whole gap can be
removed. The gap is the root mean square distance over the balls, in the mean over the horizons:
distances rather than their squares, so that what is left counts as it would on the table.
"""

import numpy as np

from models.arena.bounce_scatter import BounceScatter
from models.ball.sensor import measured
from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.exam.simulate.launches import Launches, launches
from models.exam.simulate.recordings import MARGIN, SealedTruth
from models.exam.simulate.session import played

BALLS = 100
HORIZONS = np.arange(0.1, 0.65, 0.1)  # s after the launch; the bounce is at 0.2 to 0.4 s
HELD_OUT = 5  # the stream of random numbers, beside those of the recordings


class RemovableGap:
    """The balls by which simulators are judged in the hall of one trial."""

    def __init__(self, truth: SealedTruth) -> None:
        trial = truth.trial
        random = np.random.default_rng([trial.seed, HELD_OUT])
        self._drawn: Launches = launches(trial.nominal, BALLS, trial.directions, random)
        session = played(
            truth.session.ball,
            trial.simulator,
            self._drawn.states,
            np.maximum(self._drawn.durations, HORIZONS[-1]) + MARGIN,
            BounceScatter(restitution=0.0, friction=0.0),
            random,
        )
        self._true = self._seen(session)

    def left(self, simulator: Simulator) -> float:
        """Return the gap between a simulator and the hall in mm."""
        apart = ((self._seen(simulator) - self._true) ** 2).sum(axis=2)
        flying = self._drawn.durations[:, None] >= HORIZONS
        squares = (apart * flying).sum(axis=0) / np.maximum(flying.sum(axis=0), 1)
        return 1000.0 * float(np.sqrt(squares).mean())

    def _seen(self, simulator: Simulator) -> Floats:
        # Labels that read backwards are drawn at random, and do not matter to positions.
        unused = np.random.default_rng(0)
        positions, _ = measured(simulator, self._drawn.states, HORIZONS, unused)
        return positions
