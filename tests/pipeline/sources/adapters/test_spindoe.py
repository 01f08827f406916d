"""SpinDOE: frame, labels, and the real set."""

import numpy as np
import pytest

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.sources.made_up import PATH, SPIN, TIMES, read, write_spindoe


def test_positions_times_and_labels_are_left_as_they_are_and_labels_hold_for_every_sample(tmp_path):
    write_spindoe(tmp_path)
    gathered = read(tmp_path, "spindoe")
    recordings, record = gathered.recordings, gathered.manifest.sources["spindoe"]
    shot = recordings[recordings["recording_id"] == "spindoe/001"]
    assert np.array_equal(shot["t"], TIMES)
    assert np.array_equal(shot[POSITION_COLUMNS], PATH)
    assert np.array_equal(shot[SPIN_COLUMNS], np.tile(SPIN, (4, 1)))
    assert recordings["wz"].max() == 2261.0  # doubtful, and data
    assert (record.spin, record.labels_refused) == ("per_recording", {})


@pytest.mark.parametrize(
    ("label", "reason"),
    [
        ((9, *SPIN), "label without a file"),
        ((1, 0.0, 0.0, 0.0), "label repeated"),
        ((1.5, *SPIN), "no number of a file"),
        ((-1, *SPIN), "no number of a file"),
        (("two", *SPIN), "not a number"),
        ((3, *SPIN, 5), "wrong number of fields"),
    ],
)
def test_an_unusable_label_is_refused_with_its_row(tmp_path, label, reason):
    write_spindoe(tmp_path, labels=[(1, *SPIN), label])
    record = read(tmp_path, "spindoe").manifest.sources["spindoe"]
    assert record.labels_refused[reason].rows == {"index.csv": [3]}
    assert record.rows_kept == record.rows_read == 8


def test_samples_without_a_label_and_with_one_that_no_ball_has_are_kept(tmp_path):
    write_spindoe(tmp_path, labels=[(1, 3000.0, 10.0, 0.0)])
    gathered = read(tmp_path, "spindoe")
    record = gathered.manifest.sources["spindoe"]
    assert record.labels_refused["spin above 3000 rad/s"].rows == {"001.csv": [1, 2, 3, 4]}
    assert gathered.recordings["wx"].isna().tolist() == [True] * 8


def test_the_index_is_needed(tmp_path):
    write_spindoe(tmp_path).with_name("index.csv").unlink()
    with pytest.raises(InputError, match=r"index\.csv: there is no such file"):
        read(tmp_path, "spindoe")


@pytest.mark.real
def test_the_real_set_is_whole_and_its_balls_fly_to_the_robot_and_read_low(real_data):
    gathered = read(real_data, "spindoe")
    record = gathered.manifest.sources["spindoe"]
    assert record.recordings == len(list((real_data / "spindoe").glob("*.csv"))) - 1
    assert record.rate_hz == pytest.approx(143, abs=1)
    assert {reason: group.rows for reason, group in record.rows_refused.items()} == {
        "time repeated": {"109.csv": [202]}
    }
    assert record.labels_refused == {}
    recordings = gathered.recordings
    ways = recordings.groupby("recording_id")["py"].agg(lambda y: y.iloc[-1] - y.iloc[0])
    assert (ways < -0.5).all()
    # The centre of a bouncing ball is at +20 mm; the set shows it near -2 mm, and so do we.
    over_table = recordings[recordings["py"].abs() < 1.2]
    lowest = over_table.groupby("recording_id")["pz"].min()
    assert -0.01 < lowest.median() < 0.01
