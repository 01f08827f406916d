"""Tiny sources in their upstream formats, and the settings to read them."""

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd

from rallygap.models.arena.settings import ArenaSettings
from rallygap.pipeline.io.artifacts import read_table
from rallygap.pipeline.io.source_manifest import Manifest
from rallygap.pipeline.params import IngestSettings
from rallygap.pipeline.sources.gather import TABLES, Gathered, gather

TIMES = np.array([0.0, 0.007, 0.014, 0.021])
# A ball towards -y, 5 m/s.
PATH = np.array([[0.1, 1.0, 0.3], [0.1, 0.965, 0.301], [0.1, 0.93, 0.302], [0.1, 0.895, 0.303]])
SPIN = [120.5, -358.75, 245.25]

ARENA = ArenaSettings(
    physics=None,
    game_episodes=0,  # games come in batches, which take seconds
    cannon_shots=6,
    rate_hz=200,
    position_noise=0.003,
    spin_noise=0.05,
    dropouts=0.02,
    outliers=0.01,
)


@dataclass(frozen=True)
class Read:
    """All tables of some sources."""

    manifest: Manifest
    truth: dict[str, Any] | None
    recordings: pd.DataFrame
    launches: pd.DataFrame
    points: pd.DataFrame
    true_contacts: pd.DataFrame


def read(folder: Path | None, *sources: str, arena=ARENA, seed=0) -> Read:
    """Gather ``sources`` from ``folder``."""
    settings = IngestSettings(folder=folder, sources=list(sources), arena=arena)
    with tempfile.TemporaryDirectory() as out:
        return read_again(gather(settings, seed, Path(out)), Path(out))


def read_again(gathered: Gathered, folder: Path) -> Read:
    """Read what was gathered from its folder."""
    tables = {name: read_table(folder / f"{name}.parquet") for name in TABLES}
    return Read(gathered.manifest, gathered.truth, **tables)


def lines(separator: str, *columns: np.ndarray) -> list[str]:
    """Rows of numbers as text."""
    return [separator.join(map(repr, row)) for row in np.column_stack(columns).tolist()]


def write_lines(path: Path, rows: list[str]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def write_spindoe(folder: Path, labels=((1, *SPIN), (2, 0.0, 0.0, 2261.0))) -> Path:
    """Two shots, 001 and 002, and an index."""
    rows = ["traj_file,x_spin,y_spin,z_spin", *(",".join(map(str, label)) for label in labels)]
    write_lines(folder / "spindoe" / "index.csv", rows)
    write_lines(folder / "spindoe" / "002.csv", lines(";", TIMES, PATH - [0.2, 0, 0]))
    return write_lines(folder / "spindoe" / "001.csv", lines(";", TIMES, PATH))


def write_tt3d(folder: Path) -> Path:
    """One rally, 003, that starts in the middle of a session's clock."""
    rows = ["Timestamp,X,Y,Z", *lines(",", TIMES + 15.0, PATH)]
    return write_lines(folder / "tt3d" / "003.csv", rows)


def write_isr(folder: Path, shots=("0", "2", "10")) -> Path:
    """One file of shots along +x from a launcher 0.32 m above the table, z from the floor."""
    path = folder / "isr_ball_prediction" / "no_spin.hdf5"
    path.parent.mkdir(parents=True, exist_ok=True)
    positions = np.column_stack([1.37 - PATH[:, 1], PATH[:, 0], PATH[:, 2] + 0.74])
    with h5py.File(path, "w") as file:
        for shot in shots:
            file[f"originals/{shot}/time_stamps"] = TIMES
            file[f"originals/{shot}/positions"] = positions
            file[f"originals/{shot}/velocities"] = np.zeros((4, 3))
            file[f"originals/{shot}/launch_param"] = np.zeros(5)
    return path


def launch(number: int, **changes) -> dict:
    """One ball state of competitive_robot_table_tennis."""
    values = {"pos_x": 0.1, "pos_y": 1.2, "pos_z": 0.4, "vel_x": 0.5, "vel_y": -5, "vel_z": 1.5}
    spin = {"w_vel_x": 62.8, "w_vel_y": -5.8, "w_vel_z": -7.6}
    return {"id": number, **values, **spin, **changes}


def write_competitive(folder: Path, rallies=None) -> Path:
    """Two rally states and one serve."""
    path = folder / "competitive_robot_table_tennis" / "rallies.json"
    rallies = [launch(7), launch(8)] if rallies is None else rallies
    write_lines(path.with_name("serves.json"), [json.dumps([launch(0)])])
    return write_lines(path, [json.dumps(rallies)])


def write_csv(folder: Path, name="session.csv", rows=None, settings: str | None = None) -> Path:
    """One recording with spin, and a source.yaml if there is something to say in it."""
    spins = np.tile(SPIN, (len(TIMES), 1))
    rows = ["t,x,y,z,wx,wy,wz", *lines(",", TIMES, PATH, spins)] if rows is None else rows
    if settings is not None:
        write_lines(folder / "csv" / "source.yaml", [settings])
    return write_lines(folder / "csv" / name, rows)


WRITERS = {
    "spindoe": write_spindoe,
    "tt3d": write_tt3d,
    "isr_ball_prediction": write_isr,
    "competitive_robot_table_tennis": write_competitive,
    "csv": write_csv,
}
