"""Competitive robot table tennis: launches, refused ones, and the real set."""

import pytest

from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.sources.made_up import launch, read, write_competitive, write_lines

NAME = "competitive_robot_table_tennis"


def test_launches_are_states_as_they_are(tmp_path):
    write_competitive(tmp_path)
    gathered = read(tmp_path, NAME)
    launches = gathered.launches.set_index("launch_id")
    assert list(launches.index) == [f"{NAME}/rallies/7", f"{NAME}/rallies/8", f"{NAME}/serves/0"]
    state = [0.1, 1.2, 0.4, 0.5, -5.0, 1.5, 62.8, -5.8, -7.6]
    assert launches.loc[f"{NAME}/rallies/7"].tolist() == state
    assert gathered.recordings.empty


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        (launch(9, pos_x="text"), "not a ball state"),
        (launch(9, pos_x=None), "not a ball state"),
        (launch(9, vel_z=True), "not a ball state"),
        (launch(9, vel_z=10**400), "not a ball state"),
        (launch("9"), "not a ball state"),
        ({"id": 9}, "not a ball state"),
        ([1, 2, 3], "not a ball state"),
        (launch(9, pos_x=float("nan")), "not a number"),
        (launch(9, pos_x=float("-inf")), "not a ball state"),
        (launch(9, pos_x=1e6), "farther than 20 m"),
        (launch(9, vel_x=60.0), "faster than 60 m/s"),
        (launch(7), "id repeated"),
    ],
)
def test_an_impossible_state_is_refused_with_its_place(tmp_path, entry, reason):
    write_competitive(tmp_path, [launch(7), entry])
    record = read(tmp_path, NAME).manifest.sources[NAME]
    assert record.rows_refused[reason].rows == {"rallies.json": [2]}
    assert (record.rows_read, record.rows_kept) == (3, 2)


def test_an_impossible_spin_is_refused_and_the_state_kept(tmp_path):
    write_competitive(tmp_path, [launch(7, w_vel_y=3001.0)])
    gathered = read(tmp_path, NAME)
    assert gathered.launches["wx"].isna().tolist() == [True, False]
    assert gathered.manifest.sources[NAME].labels_refused["spin above 3000 rad/s"].count == 1


@pytest.mark.parametrize("text", ['{"id": 1}', "[1, 2", "", "[" * 100_000, "[" + "1" * 5000 + "]"])
def test_a_file_that_is_no_list_of_states_is_one_error(tmp_path, text):
    write_lines(write_competitive(tmp_path), [text])
    with pytest.raises(InputError, match=r"rallies\.json.*(JSON|nothing in it)"):
        read(tmp_path, NAME)


@pytest.mark.real
def test_the_real_launches_are_whole(real_data):
    gathered = read(real_data, NAME)
    record, launches = gathered.manifest.sources[NAME], gathered.launches
    assert record.launches == record.rows_read == 12655
    assert launches["launch_id"].str.contains("/serves/").sum() == 2168
    # Serves come from the far side, and rallies from both.
    serves = launches[launches["launch_id"].str.contains("/serves/")]
    assert (serves["vy"] < 0).all()
    assert (launches["vy"] > 0).any()
