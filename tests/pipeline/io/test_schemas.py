"""Contracts: good tables pass as they are, broken ones are named with row and column."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.io.artifacts import write_table
from rallygap.pipeline.io.schemas import (
    CONTACTS,
    EPISODES,
    LAUNCHES,
    POINTS,
    POSITION_COLUMNS,
    RECORDINGS,
    SAMPLES,
    SPIN_COLUMNS,
    TRUE_CONTACTS,
    VELOCITY_COLUMNS,
    checked,
    empty,
    read_checked,
)
from rallygap.pipeline.runtime.errors import InputError


def zeros(*columns):
    return {column: np.zeros(3) for column in columns}


def recordings(**changes):
    """Three samples of one recording, without spin."""
    spins = {column: np.full(3, np.nan) for column in SPIN_COLUMNS}
    head = {"recording_id": ["lab/1"] * 3, "t": [0.0, 0.1, 0.2]}
    return pd.DataFrame({**head, **zeros(*POSITION_COLUMNS), **spins, **changes})


def launches():
    names = {"launch_id": ["a", "b", "c"]}
    return pd.DataFrame({**names, **zeros(*POSITION_COLUMNS, *VELOCITY_COLUMNS, *SPIN_COLUMNS)})


def points(**changes):
    head = {"recording_id": ["lab/1"] * 3, "start": [0.0, 2.0, 4.0], "end": [1.0, 3.0, 5.0]}
    players = {"server": ["near"] * 3, "winner": ["far"] * 3}
    ends = {"ended_by": ["net", "out", "missed"], "strokes": [1, 2, 3]}
    return pd.DataFrame({**head, **players, **ends, **changes})


def true_contacts(**changes):
    head = {"recording_id": ["lab/1"] * 3, "t": [0.0, 0.1, 0.1]}
    kinds = {"kind": ["launch", "net", "table"]}
    states = zeros(*POSITION_COLUMNS, *VELOCITY_COLUMNS, *SPIN_COLUMNS)
    return pd.DataFrame({**head, **kinds, **states, **changes})


def samples():
    head = {"recording_id": ["lab/1"] * 3, "episode_id": ["lab/1/00"] * 3, "arc": [0, 0, 1]}
    values = zeros(*POSITION_COLUMNS, *VELOCITY_COLUMNS, *SPIN_COLUMNS)
    return pd.DataFrame({**head, "t": [0.0, 0.1, 0.2], **values, "outlier": [False] * 3})


def contacts():
    head = {"recording_id": ["lab/1"] * 3, "episode_id": ["lab/1/00"] * 3, "kind": ["table"] * 3}
    return pd.DataFrame({**head, **zeros("t", *POSITION_COLUMNS, "speed_change")})


def episodes(**changes):
    head = {"episode_id": ["a", "b", "c"], "recording_id": ["lab/1"] * 3, "source": ["lab"] * 3}
    ends = {"starts_with": ["launch"] * 3, "ends_with": ["gap"] * 3}
    counts = {"samples": [5] * 3, "outliers": [0] * 3, "bounces": [1] * 3}
    values = {**head, **zeros("start", "end"), **ends, **counts, **zeros("residual")}
    shares = {"unbroken": [True] * 3, "split": ["train"] * 3, "replay_set": ["none"] * 3}
    return pd.DataFrame({**values, **shares, **changes})


TABLES = [
    (recordings, RECORDINGS),
    (launches, LAUNCHES),
    (points, POINTS),
    (true_contacts, TRUE_CONTACTS),
    (samples, SAMPLES),
    (contacts, CONTACTS),
    (episodes, EPISODES),
]


@pytest.mark.parametrize(("table", "contract"), TABLES)
def test_a_good_table_passes_unchanged_and_through_a_file(tmp_path, table, contract):
    write_table(tmp_path / "table.parquet", table())

    read = read_checked(tmp_path / "table.parquet", contract)

    pd.testing.assert_frame_equal(read, checked(table(), contract))
    pd.testing.assert_frame_equal(read, table())


@pytest.mark.parametrize(("table", "contract"), TABLES)
def test_a_file_at_fault_is_named_with_the_column(tmp_path, table, contract):
    path = tmp_path / "table.parquet"
    good = table()
    last = good.columns[-1]
    for broken, place in (
        (good.drop(columns=last), f"{last}: is missing; run the stage"),
        (good.assign(extra=1), "extra: is no column of this table; run the stage"),
        (good.assign(**{last: [[1]] * len(good)}), last),
    ):
        write_table(path, broken)
        with pytest.raises(InputError, match=rf"table\.parquet, .*{place}"):
            read_checked(path, contract)


@pytest.mark.parametrize(
    ("table", "contract", "problem"),
    [
        *[
            (recordings(**changes), RECORDINGS, place)
            for changes, place in (
                ({"px": [0.0, 20.1, 0.0]}, "row 2, px: breaks in_range"),
                ({"px": [0.0, 0.0, np.nan]}, "row 3, px: breaks not_nullable"),
                ({"px": [0.0, -np.inf, 0.0]}, "row 2, px: breaks in_range"),
                ({"px": ["0", "0", "0"]}, "px: breaks dtype"),
                ({"wx": [3000.1, 0.0, 0.0]}, "row 1, wx: breaks in_range"),
                ({"t": [0.0, 0.1, np.inf]}, "row 3, t: breaks must be finite"),
                ({"t": [0.0, 0.1, 0.1]}, ": time must grow within every recording"),
                ({"recording_id": [1, 2, 3]}, "recording_id: breaks dtype"),
                ({"recording_id": ["a", None, "a"]}, "row 2, recording_id: breaks not_nullable"),
            )
        ],
        (launches().iloc[:, ::-1], LAUNCHES, ".*is out of order"),
        (launches().assign(launch_id=["a", "b", "a"]), LAUNCHES, "row [13], launch_id"),
        (points(end=[1.0, 2.0, 5.0]), POINTS, "end must be after start"),
        (points(winner=["far", "me", "far"]), POINTS, "row 2, winner: breaks isin"),
        (points(ended_by="rain"), POINTS, "row 1, ended_by: breaks isin"),
        (true_contacts(kind="wall"), TRUE_CONTACTS, "row 1, kind: breaks isin"),
        (true_contacts(t=[0.0, 0.2, 0.1]), TRUE_CONTACTS, ": time must not go back"),
        (true_contacts(wx=[0.0, np.nan, 0.0]), TRUE_CONTACTS, "row 2, wx: breaks not_nullable"),
        (episodes(split=["train", "test", "train"]), EPISODES, ": every recording must be in one"),
        (episodes(episode_id=["a", "b", "a"]), EPISODES, "row [13], episode_id"),
    ],
)
def test_what_cannot_be_is_named_with_its_place(table, contract, problem):
    with pytest.raises(InputError, match=f"table of {contract.name}.*{problem}"):
        checked(table, contract)


def test_time_may_start_again_in_another_recording():
    table = recordings(recording_id=["a", "a", "b"], t=[0.0, 0.1, 0.0])
    assert checked(table, RECORDINGS)["t"].tolist() == [0.0, 0.1, 0.0]


@pytest.mark.parametrize(("table", "contract"), TABLES)
def test_a_table_without_rows_keeps_its_contract(table, contract):
    assert checked(table().iloc[:0], contract).empty
    pd.testing.assert_frame_equal(checked(empty(contract), contract), table().iloc[:0])
