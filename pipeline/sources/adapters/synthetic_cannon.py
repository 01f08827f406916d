"""A simulated cannon session, for a machine without measured balls. Nothing of it was measured."""

import numpy as np
import pandas as pd

from models.arena.cameras import Cameras
from models.arena.cannon import cannon_launches
from models.ball.simulator import Simulator, SimulatorError
from models.ball.simulators import shipped
from models.ball.state import TABLE_HALF_LENGTH
from pipeline.contracts import POSITION_COLUMNS, SPIN_COLUMNS
from pipeline.errors import InputError
from pipeline.sources.settings import SyntheticCannonSettings
from pipeline.sources.source import Description, RawTable, SourceContext, SourceData

LONGEST_SHOT = 1.5  # s
LAST_SEEN = -TABLE_HALF_LENGTH - 0.5  # m along y: where the cameras lose the ball
LOWEST_SEEN = 0.0  # m


class SyntheticCannon:
    """Shots of the arena's cannon in a shipped simulator, seen by noisy cameras."""

    name = "synthetic_cannon"

    def read(self, context: SourceContext) -> SourceData:
        """Simulate the session that the settings describe; the same seed gives the same balls."""
        settings = context.settings.synthetic_cannon
        random = np.random.default_rng([context.seed, 0])
        simulator = _simulator(settings.simulator)
        launches = cannon_launches(simulator, settings.shots, random)
        times = np.arange(0.0, LONGEST_SHOT, 1 / settings.rate_hz)
        flights = simulator.fly(launches, times).states
        cameras = _cameras(settings)
        tables = [
            RawTable(f"{shot:03d}", _measured(times, flight, cameras, random))
            for shot, flight in enumerate(flights)
        ]
        return SourceData(_describe(self.name, settings), tables)


def _measured(
    times: np.ndarray, flight: np.ndarray, cameras: Cameras, random: np.random.Generator
) -> pd.DataFrame:
    """Return the samples of one shot until the ball leaves the cameras' sight."""
    gone = (flight[:, 1] < LAST_SEEN) | (flight[:, 2] < LOWEST_SEEN)
    length = int(gone.argmax()) if gone.any() else len(times)
    positions, spins, seen = cameras.measure(flight[:length], random)
    rows = pd.DataFrame(np.hstack([positions, spins]), columns=[*POSITION_COLUMNS, *SPIN_COLUMNS])
    rows.insert(0, "t", times[:length])
    rows.insert(0, "row", np.arange(1, length + 1))
    return rows[seen]


def _simulator(name: str) -> Simulator:
    try:
        return shipped(name)
    except SimulatorError as error:
        field = "ingest.synthetic_cannon.simulator"
        raise InputError("params.yaml", str(error), field=field) from None


def _cameras(settings: SyntheticCannonSettings) -> Cameras:
    return Cameras(
        position_noise=settings.position_noise,
        spin_noise=settings.spin_noise,
        dropouts=settings.dropouts,
        outliers=settings.outliers,
    )


def _describe(name: str, settings: SyntheticCannonSettings) -> Description:
    return Description(
        name=name,
        kind="cannon",
        spin="per_sample",
        licence="MIT",
        stated_rate_hz=settings.rate_hz,
        note=f"Synthetic: simulated with {settings.simulator}, not measured. Errors on it say how "
        "well a predictor knows that simulator, and nothing about real balls.",
    )


source = SyntheticCannon()
