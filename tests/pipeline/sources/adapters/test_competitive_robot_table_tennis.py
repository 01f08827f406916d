"""Competitive robot table tennis: launches, refused ones, and the real set."""

import pytest

from tests.pipeline.sources.made_up import launch, read, write_competitive

NAME = "competitive_robot_table_tennis"


def test_launches_are_states_as_they_are_without_impossible_spins(tmp_path):
    write_competitive(tmp_path, [launch(7), launch(8, w_vel_y=3001.0)])
    gathered = read(tmp_path, NAME)
    launches = gathered.launches.set_index("launch_id")
    assert list(launches.index) == [f"{NAME}/rallies/7", f"{NAME}/rallies/8", f"{NAME}/serves/0"]
    state = [0.1, 1.2, 0.4, 0.5, -5.0, 1.5, 62.8, -5.8, -7.6]
    assert launches.loc[f"{NAME}/rallies/7"].tolist() == state
    assert launches["wx"].isna().tolist() == [False, True, False]
    assert gathered.manifest.sources[NAME].labels_refused["spin above 3000 rad/s"].count == 1
    assert gathered.recordings.empty


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        (launch(9, pos_x="text"), "not a ball state"),
        (launch(9, vel_z=True), "not a ball state"),
        (launch(9, vel_z=10**400), "not a ball state"),
        (launch("9"), "not a ball state"),
        ({"id": 9}, "not a ball state"),
        ([1, 2, 3], "not a ball state"),
        (launch(9, pos_x=float("nan")), "not a number"),
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


@pytest.mark.real
def test_the_real_launches_are_whole(real_data):
    gathered = read(real_data, NAME)
    record, launches = gathered.manifest.sources[NAME], gathered.launches
    assert record.launches == record.rows_read == 12655
    serves = launches[launches["launch_id"].str.contains("/serves/")]
    assert len(serves) == 2168
    # Serves come from the far side, and rallies from both.
    assert (serves["vy"] < 0).all()
    assert (launches["vy"] > 0).any()
