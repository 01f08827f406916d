"""TT3D: frame, clock, and the real set."""

import numpy as np
import pytest

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS
from tests.pipeline.sources.made_up import PATH, TIMES, read, write_tt3d


def test_positions_and_the_running_clock_are_left_as_they_are(tmp_path):
    write_tt3d(tmp_path)
    gathered = read(tmp_path, "tt3d")
    recordings = gathered.recordings
    assert set(recordings["recording_id"]) == {"tt3d/003"}
    assert np.array_equal(recordings["t"], TIMES + 15.0)
    assert np.array_equal(recordings[POSITION_COLUMNS], PATH)
    assert recordings[SPIN_COLUMNS].isna().all(axis=None)
    assert gathered.manifest.sources["tt3d"].spin == "none"


@pytest.mark.real
def test_the_real_rallies_are_whole_and_on_the_table(real_data):
    gathered = read(real_data, "tt3d")
    record, recordings = gathered.manifest.sources["tt3d"], gathered.recordings
    assert record.recordings == len(list((real_data / "tt3d").glob("*.csv")))
    assert record.rows_kept == record.rows_read == 7135
    assert record.rate_hz == pytest.approx(179, abs=1)
    assert 0.01 < recordings["pz"].min() < 0.03  # a ball on the table has its centre at 0.02 m
    ways = recordings.groupby("recording_id")["py"].agg(lambda y: y.iloc[1] - y.iloc[0])
    assert (ways > 0).any()
    assert (ways < 0).any()
