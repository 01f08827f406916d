"""The recordings of the README's example of `rallygap diagnose`."""

from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.models.ball.simulators import shipped

SHOTS = 30
NOISE, SPIN_NOISE = 0.002, 0.05  # m, and share of a component
TIMES = np.arange(0.0, 0.6, 0.005)  # s


def write_recordings(folder: Path) -> None:
    """Write one CSV file for each shot, flown by another simulator than the literature's."""
    folder.mkdir()
    simulator = shipped("literature").amended("drag", cd=0.47)
    simulator = simulator.amended("table_bounce", restitution=0.90, friction=0.25)
    random = np.random.default_rng(0)
    for number in range(SHOTS):
        direction = 1.0 if number % 2 else -1.0
        velocity = random.normal([0.0, 5.5, 1.0], [0.4, 1.0, 0.8]) * [1.0, direction, 1.0]
        spin = random.normal(0.0, 150.0, 3)
        state = np.array([0.0, -1.3 * direction, 0.3, *velocity, *spin])
        states = simulator.fly(state[None], TIMES[None]).states[0]
        positions = states[:, :3] + random.normal(0.0, NOISE, (len(TIMES), 3))
        spins = states[:, 6:] * (1 + random.normal(0.0, SPIN_NOISE, (len(TIMES), 3)))
        columns = ["t", "x", "y", "z", "wx", "wy", "wz"]
        table = pd.DataFrame(np.column_stack([TIMES, positions, spins]), columns=columns)
        table.to_csv(folder / f"{number:02}.csv", index=False, float_format="%.6f")
