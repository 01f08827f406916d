"""Launch velocities that bring a ball over the net to a target on the table."""

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS, NET_HEIGHT, STATE_SIZE
from rallygap.models.ball.types import Floats

CORRECTIONS = 5  # iterations; millimetres remain, less than the players' errors
PATH_SAMPLES = 16  # points of a flight at which its height over the net is taken
LENGTHENING = 1.12  # factor on the time of a flight that would not clear the net
MAX_LENGTHENINGS = 8


def aim_launches(
    simulator: Simulator,
    positions: Floats,
    spins: Floats,
    targets: Floats,
    times: Floats,
    clearances: Floats,
) -> Floats:
    """Return (B, 9) launches that reach their targets; longer flights where the net is in the way.

    Args:
        simulator: physics that the players know.
        positions: (B, 3) racket contacts, m.
        spins: (B, 3) after the stroke, rad/s.
        targets: (B, 2) on the table, m.
        times: (B,) durations of the flights, s.
        clearances: (B,) smallest distances between ball and net, m. Where no flight keeps them,
            the last one tried is returned.
    """
    air, times = simulator.without_surfaces(), times.copy()
    launches = _reaching(air, positions, spins, targets, times)
    for _ in range(MAX_LENGTHENINGS):
        low = np.flatnonzero(_above_net(air, launches, times) < clearances)
        if not len(low):
            break
        times[low] *= LENGTHENING
        launches[low] = _reaching(air, positions[low], spins[low], targets[low], times[low])
    return launches


def _reaching(
    air: Simulator, positions: Floats, spins: Floats, targets: Floats, times: Floats
) -> Floats:
    """Return launches that reach their targets at given times (fixed-point iteration)."""
    ends = np.column_stack([targets, np.full(len(targets), BALL_RADIUS)])
    span = times[:, None]
    launches = np.empty((len(positions), STATE_SIZE))
    launches[:, :3], launches[:, 6:] = positions, spins
    launches[:, 3:6] = (ends - positions) / span + [0.0, 0.0, 4.9] * span
    for _ in range(CORRECTIONS):
        reached = air.fly(launches, span).states[:, 0, :3]
        launches[:, 3:6] += (ends - reached) / span
    return launches


def _above_net(air: Simulator, launches: Floats, times: Floats) -> Floats:
    """Return how far above the net balls pass (m)."""
    paths = air.fly(launches, times[:, None] * np.linspace(0, 1, PATH_SAMPLES)).states
    y, z = paths[..., 1] * np.sign(launches[:, 4:5]), paths[..., 2]
    ahead = np.clip((y >= 0).argmax(axis=1), 1, None)
    rows = np.arange(len(paths))
    y0, y1, z0, z1 = y[rows, ahead - 1], y[rows, ahead], z[rows, ahead - 1], z[rows, ahead]
    at_net = z0 - y0 * (z1 - z0) / np.where(y1 == y0, 1.0, y1 - y0)
    return at_net - NET_HEIGHT - BALL_RADIUS
