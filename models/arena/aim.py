"""Aim: the launch velocity that brings a ball over the net to a place on the table."""

import numpy as np
from numpy.typing import NDArray

from models.ball.catalogue import catalogue
from models.ball.simulator import Simulator
from models.ball.state import BALL_RADIUS, NET_HEIGHT, STATE_SIZE

Floats = NDArray[np.float64]

CORRECTIONS = 5  # leave millimetres: players are not more exact than that
LOOKS = 16  # along a flight, for its height over the net
LONGER = 1.12  # factor on the time of a flight that would not clear the net
MOST_LENGTHENINGS = 8


def aimed(
    simulator: Simulator,
    positions: Floats,
    spins: Floats,
    targets: Floats,
    times: Floats,
    clearances: Floats,
) -> Floats:
    """Return launches that reach their targets, after a longer flight where the net asks for it.

    Args:
        simulator: the hall in which the players practise.
        positions: (B, 3) where the balls are struck.
        spins: (B, 3) that they get.
        targets: (B, 2) places on the table.
        times: (B,) s in which the balls should get there.
        clearances: (B,) m between ball and net, at least.

    Returns:
        (B, 9) launch states. Where no arc clears the net, the highest that was tried.
    """
    air, times = in_air(simulator), times.copy()
    launches = _reaching(air, positions, spins, targets, times)
    for _ in range(MOST_LENGTHENINGS):
        low = np.flatnonzero(_above_net(air, launches, times) < clearances)
        if not len(low):
            break
        times[low] *= LONGER
        launches[low] = _reaching(air, positions[low], spins[low], targets[low], times[low])
    return launches


def in_air(simulator: Simulator) -> Simulator:
    """Return a hall without table and net."""
    kinds = catalogue()
    return Simulator(
        {n: values for n, values in simulator.effects.items() if kinds[n].acts == "flight"}
    )


def _reaching(
    air: Simulator, positions: Floats, spins: Floats, targets: Floats, times: Floats
) -> Floats:
    """Return launches that are at their targets at given times (fixed-point iteration)."""
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
    paths = air.fly(launches, times[:, None] * np.linspace(0, 1, LOOKS)).states
    y, z = paths[..., 1] * np.sign(launches[:, 4:5]), paths[..., 2]
    ahead = np.clip((y >= 0).argmax(axis=1), 1, None)
    rows = np.arange(len(paths))
    y0, y1, z0, z1 = y[rows, ahead - 1], y[rows, ahead], z[rows, ahead - 1], z[rows, ahead]
    at_net = z0 - y0 * (z1 - z0) / np.where(y1 == y0, 1.0, y1 - y0)
    above: Floats = at_net - NET_HEIGHT - BALL_RADIUS
    return above
