"""Shots to replay, and launches, as ingest and segment would leave them."""

import numpy as np
import pandas as pd

from rallygap.models.policy.settings import SensorNoise
from rallygap.pipeline.io.artifacts import read_json, write_json, write_table
from rallygap.pipeline.io.schemas import LAUNCHES, STATE_COLUMNS, checked, empty
from rallygap.pipeline.params import Sim2RealSettings, ToleranceSettings
from tests.pipeline.measured_shots import shot_tables, source_record, write_inputs

SETTINGS = Sim2RealSettings(
    group="small",
    simulator="imperfect_c",
    learned=["tiny"],
    launches=6,
    noise=SensorNoise(position=0.003, spin=0.05),
    tolerance=ToleranceSettings(shots=6, errors_cm=[0.0, 40.0]),
)
SOURCE = "thrown"  # of the launches
LAUNCH = np.array([0.1, 1.3, 0.3, 0.2, -6.0, 1.2, -50.0, 10.0, 5.0])


def replayed(place, number, **changes):
    """The tables of a shot of the arena that is kept for replaying."""
    return shot_tables(place, number, **{"split": "replay", "replay_set": "stroke_pro", **changes})


def moved(tables, columns, change):
    """The tables with ``change`` made to some columns of the samples."""
    samples, *others = tables
    return samples.assign(**{name: change(samples[name]) for name in columns}), *others


def rotated(tables):
    """The tables of a shot that flies the other way."""
    return moved(tables, ["px", "py", "vx", "vy"], lambda column: -column)


def launched(*states):
    """The table of launches."""
    rows = pd.DataFrame(np.array(states), columns=STATE_COLUMNS)
    rows.insert(0, "launch_id", [f"{SOURCE}/rallies/{number}" for number in range(len(rows))])
    return checked(rows, LAUNCHES)


def write_replays(root, shots=(), sources=("arena", "labelled", "plain"), launches=None):
    """Write all shots of some sources, ``shots`` beside them, and launches."""
    write_inputs(root, shots=shots, sources=sources)
    ingested = root / "artifacts" / "ingest"
    manifest = read_json(ingested / "manifest.json")
    manifest["sources"] |= {"plain": source_record("plain", "none")}
    manifest["sources"] |= {SOURCE: source_record(SOURCE, "per_recording")}
    write_json(ingested / "manifest.json", manifest)
    write_table(ingested / "launches.parquet", empty(LAUNCHES) if launches is None else launches)
    return root / "artifacts"
