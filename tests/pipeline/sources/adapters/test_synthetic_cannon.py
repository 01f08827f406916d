"""The simulated session: repeatable, noisy as set, and said to be synthetic."""

import numpy as np
import pytest

from models.ball.simulators import shipped
from pipeline.contracts import POSITION_COLUMNS, SPIN_COLUMNS
from pipeline.errors import InputError
from tests.pipeline.sources.made_up import CANNON, read


def session(seed=0, **changes):
    return read(None, "synthetic_cannon", cannon=CANNON.model_copy(update=changes), seed=seed)


def test_it_needs_no_folder_and_says_that_it_is_synthetic():
    record = session().manifest.sources["synthetic_cannon"]

    assert record.recordings == CANNON.shots
    assert record.kind == "cannon"
    assert record.note.startswith("Synthetic: simulated with ground_truth, not measured")
    assert record.rate_hz == 200.0
    assert record.files == []


def test_the_same_seed_gives_the_same_samples():
    assert session().recordings.equals(session().recordings)
    assert not session().recordings.equals(session(seed=1).recordings)


def test_balls_come_from_the_far_end_and_bounce_on_the_table():
    recordings = session(position_noise=0.0, outliers=0.0, dropouts=0.0).recordings

    shots = recordings.groupby("recording_id")
    assert (shots["py"].first() > 1.37).all()
    assert (shots["py"].last() < -1.3).all()
    over_table = recordings[recordings["py"] > -1.37].groupby("recording_id")
    assert over_table["pz"].min().between(0.0199, 0.05).all()
    assert np.allclose(shots["t"].diff().dropna(), 0.005)


def test_without_noise_the_samples_are_the_simulators():
    recordings = session(position_noise=0.0, outliers=0.0, dropouts=0.0, spin_noise=0.0).recordings
    first = recordings[recordings["recording_id"] == "synthetic_cannon/000"]
    path, spins = first[POSITION_COLUMNS].to_numpy(), first[SPIN_COLUMNS].to_numpy()
    # Central difference: velocity at the second sample, 5 ms on.
    start = np.concatenate([path[1], (path[2] - path[0]) / 0.01, spins[1]])

    flown = shipped("ground_truth").fly(start, 0.005 * np.arange(40)).states[0, :, :3]

    assert np.abs(flown - path[1:41]).max() < 1e-3


def test_dropouts_leave_gaps_in_an_otherwise_even_clock():
    times = session(dropouts=0.2).recordings.groupby("recording_id")["t"]

    steps = times.diff().dropna() / 0.005
    assert np.allclose(steps, steps.round())
    assert (steps.round() > 1).mean() == pytest.approx(0.2, abs=0.06)


def test_an_unknown_simulator_names_the_setting():
    with pytest.raises(InputError, match=r"synthetic_cannon\.simulator: no simulator 'moon'"):
        session(simulator="moon")
