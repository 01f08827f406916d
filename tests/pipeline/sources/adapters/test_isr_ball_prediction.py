"""ball_prediction: the turn into the table frame, the order of shots, and the real set."""

import h5py
import numpy as np
import pytest

from rallygap.pipeline.io.schemas import POSITION_COLUMNS
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.sources.made_up import PATH, TIMES, read, write_isr

NAME = "isr_ball_prediction"


def write_changed(folder, changes):
    """Write shots, of which some parts are others or None."""
    with h5py.File(write_isr(folder), "r+") as file:
        for name, value in changes.items():
            del file[name]
            if value is not None:
                file[name] = value


def test_shots_keep_their_order_and_are_turned_towards_the_robot_over_the_table(tmp_path):
    write_isr(tmp_path)
    recordings = read(tmp_path, NAME).recordings
    names = recordings["recording_id"].unique()
    assert [name[-3:] for name in names] == ["000", "002", "010"]
    shot = recordings[recordings["recording_id"] == f"{NAME}/no_spin_000"]
    assert np.allclose(shot[POSITION_COLUMNS], PATH, atol=1e-12)
    assert np.array_equal(shot["t"], TIMES)


def test_a_refused_sample_is_named_with_its_shot(tmp_path):
    write_changed(tmp_path, {"originals/2/time_stamps": [*TIMES[:2], np.nan, TIMES[3]]})
    record = read(tmp_path, NAME).manifest.sources[NAME]
    assert record.rows_refused["not a number"].rows == {"no_spin.hdf5/originals/2": [3]}


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"originals": None}, ""),
        ({"originals/0/positions": None}, ""),
        ({"originals/0/time_stamps": 0.0}, ""),
        ({f"originals/{shot}": None for shot in (0, 2, 10)}, "there is no shot in it"),
        (
            {"originals/2/time_stamps": np.zeros(0), "originals/2/positions": np.zeros((0, 3))},
            "shot 2 has no samples",
        ),
        ({"originals/2/positions": np.zeros((5, 3))}, r"shot 2 has \(4,\) times, \(5, 3\) pos"),
    ],
)
def test_another_hdf5_file_is_one_error(tmp_path, changes, problem):
    write_changed(tmp_path, changes)
    with pytest.raises(InputError, match=rf"no_spin\.hdf5: is no whole HDF5 file.*{problem}"):
        read(tmp_path, NAME)


def test_two_shots_of_one_name_are_one_error(tmp_path):
    write_isr(tmp_path, shots=("1", "01"))
    with pytest.raises(InputError, match=r"/originals/0?1: there is another recording no_spin_001"):
        read(tmp_path, NAME)


@pytest.mark.real
def test_the_real_shots_bounce_on_the_table(real_data):
    gathered = read(real_data, NAME)
    record, recordings = gathered.manifest.sources[NAME], gathered.recordings
    assert record.recordings == 73
    assert record.rows_kept == record.rows_read
    assert record.rate_hz == pytest.approx(179, abs=1)
    lowest = recordings.loc[recordings.groupby("recording_id")["pz"].idxmin()]
    # Between two pictures, 5.6 ms apart, the ball is up to 10 mm above its lowest point.
    assert lowest["pz"].between(0.018, 0.035).mean() > 0.7
    assert lowest["pz"].min() > 0.018
    assert lowest["py"].between(-1.37, 0.0).all()
    ways = recordings.groupby("recording_id")["py"].agg(lambda y: y.iloc[-1] - y.iloc[0])
    assert (ways < -2.0).all()
