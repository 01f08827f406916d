"""The exported windows hold the histories and nothing of the futures."""

import numpy as np
import pandas as pd

from rallygap.models.predictors.protocol import HISTORY
from rallygap.pipeline.benchmark.windows import window_ids, window_table
from rallygap.pipeline.evaluation.evaluation_windows import read_test_sets
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS
from tests.pipeline.measured_shots import params, write_inputs

EVERY = params().evaluate_predictor.window_every_ms / 1000  # s


def test_the_table_holds_every_history_exactly_and_nothing_of_a_future(sets):
    table = window_table(sets)
    for one in sets:
        rows = table[table["set"] == one.name].set_index("window_id")
        history = one.windows.history
        for name, states, mask in zip(window_ids(one), history.states, history.mask, strict=True):
            window = rows.loc[name]
            assert len(window) == HISTORY
            found = window[[*POSITION_COLUMNS, *SPIN_COLUMNS]]
            np.testing.assert_array_equal(found, np.where(mask, states, np.nan))
            assert (window["position_measured"] == mask[:, :3].all(axis=1)).all()
            assert (window["spin_measured"] == mask[:, 3:].all(axis=1)).all()
        future = one.windows.future[..., 0][one.windows.measured[..., 0]]
        assert len(future) and not set(rows["px"]) & set(future)


def test_every_flight_has_one_window_of_those_that_are_evaluated(root, sets):
    for one, whole in zip(sets, read_test_sets(root / "artifacts", EVERY), strict=True):
        assert len(whole.windows) > len(one.windows) == len(whole.episodes)
        assert sorted(one.recordings) == sorted(each.recording_id for each in one.episodes)
        assert set(window_ids(one)) <= set(window_ids(whole))


def test_ids_and_rows_do_not_reveal_the_order(sets):
    table = window_table(sets)
    ids = np.concatenate([window_ids(one) for one in sets])
    assert len(set(ids)) == len(ids)
    assert {len(name) for name in ids} == {16}
    for one in sets:
        mine = table[table["set"] == one.name]["window_id"].unique()
        assert list(mine) == sorted(mine) != list(window_ids(one))
    assert not {"recording_id", "episode_id", "anchor"} & set(table)
    assert table.groupby("window_id")["t"].agg(["min", "max"]).drop_duplicates().shape[0] == 1


def test_the_id_depends_on_the_future(tmp_path, root):
    write_inputs(tmp_path, sources=("plain",))
    path = tmp_path / "artifacts" / "segment" / "samples.parquet"
    samples = pd.read_parquet(path)
    samples.loc[samples["t"] == samples["t"].max() - 0.005, "px"] += 0.001  # no history has it
    samples.to_parquet(path, index=False)
    (changed,) = read_test_sets(tmp_path / "artifacts", EVERY)
    (plain,) = (one for one in read_test_sets(root / "artifacts", EVERY) if one.name == "plain")
    same = window_ids(changed) == window_ids(plain)
    assert same.any()
    assert not same.all()
    np.testing.assert_array_equal(changed.windows.history.states, plain.windows.history.states)
