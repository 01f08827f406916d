"""Write the example recordings: shots with more drag and a lower restitution than `literature` has.

    python docs/examples/record_shots.py recordings

One CSV file a shot, with noise of 2 mm and spin labels with errors of 5 %. The files in
docs/examples/recordings are those that this script writes.
"""

import sys
from pathlib import Path

import numpy as np

from rallygap.models.ball.simulators import shipped

SHOTS = 30
NOISE, SPIN_NOISE = 0.002, 0.05  # m, and share of a component
TIMES = np.arange(0.0, 0.6, 0.005)  # s
COLUMNS = "t,x,y,z,wx,wy,wz"
DIGITS = ["%.3f", *["%.5f"] * 3, *["%.3f"] * 3]


def record_shots(folder: Path) -> None:
    """Write the recordings into a new folder."""
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
        rows = np.column_stack([TIMES, positions, spins])
        path = folder / f"{number:02}.csv"
        np.savetxt(path, rows, DIGITS, delimiter=",", header=COLUMNS, comments="")


if __name__ == "__main__":
    record_shots(Path(sys.argv[1]))
