"""What a table does to balls, contact by contact, whatever law the engine has for it.

States just before and just after a contact follow from states shortly before and after it, by the
flight that the audit has found.
"""

from dataclasses import dataclass

import numpy as np

from rallygap.models.audit.probes import GRAVITY, Flown
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS, SPIN, VELOCITY
from rallygap.models.ball.types import Bools, Floats

# Share of the slip that the velocity changes by where the contact point comes to rest, by the
# moment of inertia: 1 / (1 + m r^2 / I).
SHELL, SOLID = 2 / 5, 2 / 7
MET = 0.5  # of the speed before: a ball that falls on gets faster
LEAST_SLIP = 1.0  # m/s, below which the share says little


@dataclass(frozen=True)
class Bounces:
    """The contacts of B bounce probes.

    Attributes:
        met: (B,) whether the downward speed after is less than ``MET`` times that before.
        bounced: (B,) whether the ball rises above the table afterwards.
        restitution: (B,) normal speed after over before; NaN without a bounce.
        grip: (B,) change of the velocity along the table over the slip; NaN without a bounce, or
            with little slip.
        speed: (B,) m/s, normal to the table before.
        slip: (B,) m/s, of the lowest point before.
    """

    met: Bools
    bounced: Bools
    restitution: Floats
    grip: Floats
    speed: Floats
    slip: Floats

    @property
    def restitution_scatter(self) -> float:
        """Standard deviation of the restitution, beyond what is linear in speed and slip."""
        rows = np.stack([np.ones(len(self.speed)), self.speed, self.slip], axis=1)[self.bounced]
        measured = self.restitution[self.bounced]
        return float((measured - rows @ np.linalg.lstsq(rows, measured, rcond=None)[0]).std())

    @classmethod
    def of(cls, flown: Flown, simulator: Simulator) -> "Bounces":
        """Return the contacts of the bounce probes that an engine flew.

        Args:
            flown: the bounce probes.
            simulator: with the engine's flight.
        """
        flight, after = simulator.without_surfaces(), flown.states[:, 0]
        first = flown.probes.states
        above, fall = first[:, 2] - BALL_RADIUS, -first[:, 5]
        # s until balls meet the table, under gravity alone.
        moments = ((np.sqrt(fall**2 + 2 * GRAVITY * above) - fall) / GRAVITY)[:, None]
        before = flight.fly(first, moments).states[:, 0]
        since = flown.probes.times[0] - moments
        risen = flight.fly(after, -since).states[:, 0]
        bounced = (after[:, 2] > BALL_RADIUS) & (risen[:, 5] > 0.0)
        spin, velocity = before[:, SPIN], before[:, VELOCITY]
        # Of the lowest points.
        across = velocity[:, 0] - BALL_RADIUS * spin[:, 1]
        along = velocity[:, 1] + BALL_RADIUS * spin[:, 0]
        slip = np.linalg.norm(np.stack([across, along], axis=1), axis=1)
        change = np.linalg.norm((risen - before)[:, VELOCITY][:, :2], axis=1)
        return cls(
            after[:, 5] > MET * before[:, 5],
            bounced,
            np.where(bounced, -risen[:, 5] / before[:, 5], np.nan),
            np.where(bounced & (slip > LEAST_SLIP), change / np.maximum(slip, LEAST_SLIP), np.nan),
            -before[:, 5],
            slip,
        )
