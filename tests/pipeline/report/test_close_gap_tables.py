"""Tables of verdicts, by hand."""

import pandas as pd
import pytest

from rallygap.pipeline.report.close_gap import (
    cause_table,
    error_table,
    stability_table,
    verdict_table,
)
from tests.pipeline.verdicts import CAMERA, GRAVITY, MINOR, MISFIT, WIND, diagnosed, verdict


def three():
    """Splits that find a wind, another wind and a gravity, and nothing."""
    stronger = WIND.model_copy(update={"estimate": 0.65})
    found = [verdict(), verdict("ambiguous", (stronger, GRAVITY)), verdict("no_gap", (), gap=None)]
    return [diagnosed(one, split=split) for split, one in enumerate(found)]


def test_a_case_has_a_row_with_its_causes_as_text():
    rows = verdict_table(three())
    assert rows["verdict"].tolist() == ["named", "ambiguous", "no_gap"]
    assert rows["causes"][0] == "wind.x 0.61 m/s (0.59 to 0.63)"
    assert "gravity.g or buoyancy.b 10.3 m/s^2 (10.2 to 10.4)" in rows["causes"][1]
    assert rows["removable_closed"][0] == 0.9
    assert rows.loc[0, ["reduction_low_mm", "reduction_high_mm"]].tolist() == [12.0, 18.0]
    assert rows["shots"].tolist() == [4, 4, 4]
    assert rows.loc[2, ["causes", "removable_closed", "closed_low"]].isna().all()


def test_a_cause_has_a_row_with_its_numbers():
    rows = cause_table(three()).set_index(["split", "cause"])
    assert rows.loc[(1, "gravity.g"), "possible"] == "gravity.g, buoyancy.b"
    assert rows.loc[(0, "wind.x"), ["nominal", "estimate", "low", "high"]].tolist() == [
        0.0,
        0.61,
        0.59,
        0.63,
    ]
    assert len(rows) == 3


def test_causes_have_their_role_and_worth():
    whole = diagnosed(verdict(causes=(WIND, CAMERA, MINOR)))
    rows = cause_table([whole]).set_index("cause")
    assert rows["role"].tolist() == ["leading", "sensor", "minor"]
    worth = rows.loc["wind.x", ["worth_mm", "worth_low", "worth_high"]]
    assert worth.tolist() == [5.3, 2.8, 7.9]
    assert pd.isna(rows.loc["spin_decay.c", "worth_mm"])


def test_minor_structure_is_counted_and_no_cause_of_a_case():
    whole = diagnosed(verdict(causes=(WIND, CAMERA, MINOR), checks=(MISFIT,)))
    (row,) = verdict_table([whole]).to_dict("records")
    assert "spin_decay" not in row["causes"] and "camera_distortion" in row["causes"]
    assert (row["minor"], row["misfits"]) == (1, "prediction")
    assert stability_table([whole])["cause"].tolist() == ["wind.x"]


def test_errors_are_listed_from_100_to_300_ms():
    rows = error_table(three())
    assert rows.groupby("split")["horizon_ms"].apply(list).tolist() == [[100, 200, 300]] * 2
    last = rows.iloc[-1]
    assert last[["before_mm", "after_mm", "floor_mm"]].tolist() == [40.0, 12.0, 11.0]
    ends = last[["before_low", "before_high", "after_low", "after_high"]]
    assert ends.tolist() == [36.0, 45.0, 10.5, 14.0]


def test_stability_counts_the_splits_with_a_cause():
    rows = stability_table(three()).set_index("cause")
    assert rows["found"].to_dict() == {"wind.x": 2, "gravity.g": 1}
    assert (rows["splits"] == 3).all()
    assert (rows["verdicts"] == "1 named, 1 ambiguous, 1 no_gap").all()
    wind = rows.loc["wind.x"]
    assert wind[["estimate", "lowest", "highest"]].tolist() == pytest.approx([0.63, 0.61, 0.65])


def test_a_simulator_without_a_cause_has_a_row():
    none = diagnosed(verdict("no_gap", ()), simulator_name="other")
    rows = stability_table([*three(), none]).set_index("simulator")
    assert pd.isna(rows.loc["other", "cause"])
    assert rows.loc["other", "verdicts"] == "1 no_gap"
    assert len(rows.loc["mine"]) == 2


def test_without_any_cause_the_table_of_causes_is_empty():
    rows = cause_table([diagnosed(verdict("no_gap", ()))])
    assert rows.empty and "estimate" in rows
