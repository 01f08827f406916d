"""Tables of many verdicts, by hand."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.report.close_gap import (
    ERRORS,
    cause_table,
    error_table,
    stability_table,
    verdict_table,
)
from tests.pipeline.verdicts import CAMERA, GAP, GRAVITY, MINOR, MISFIT, WIND, diagnosed, verdict


def three_splits():
    """Splits that find a wind, another wind and a gravity, and nothing."""
    stronger = WIND.model_copy(update={"estimate": 0.65})
    found = [verdict(), verdict("ambiguous", (stronger, GRAVITY)), verdict("no_gap", (), gap=None)]
    return [diagnosed(one, split=split) for split, one in enumerate(found)]


def test_a_case_has_a_row_with_its_causes_as_text():
    rows = verdict_table(three_splits())
    assert rows["verdict"].tolist() == ["named", "ambiguous", "no_gap"]
    assert rows["causes"][0] == "wind.x 0.61 m/s (0.59 to 0.63)"
    assert "gravity.g or buoyancy.b 10.3 m/s^2 (10.2 to 10.4)" in rows["causes"][1]
    numbers = ["removable_closed", "reduction_low_mm", "reduction_high_mm", "landing_after_mm"]
    assert rows.loc[0, numbers].tolist() == [0.9, 12.0, 18.0, 14.0]
    assert rows["shots"].tolist() == [4, 4, 4]
    assert rows.loc[2, ["causes", *numbers, "closed_low"]].isna().all()


def test_causes_have_their_numbers_role_and_worth_and_minor_ones_are_counted():
    whole = diagnosed(verdict(causes=(WIND, CAMERA, MINOR), checks=(MISFIT,)))
    (row,) = verdict_table([whole]).to_dict("records")
    assert "spin_decay" not in row["causes"] and "camera_distortion" in row["causes"]
    assert (row["minor"], row["misfits"]) == (1, "prediction")
    assert stability_table([whole])["cause"].tolist() == ["wind.x"]
    rows = cause_table([whole]).set_index("cause")
    assert rows["role"].tolist() == ["leading", "sensor", "minor"]
    numbers = ["nominal", "estimate", "low", "high", "worth_mm", "worth_low", "worth_high"]
    assert rows.loc["wind.x", numbers].tolist() == [0.0, 0.61, 0.59, 0.63, 5.3, 2.8, 7.9]
    assert pd.isna(rows.loc["spin_decay.c", "worth_mm"])
    rows = cause_table(three_splits()).set_index(["split", "cause"])
    assert len(rows) == 3
    assert rows.loc[(1, "gravity.g"), "possible"] == "gravity.g, buoyancy.b"


def test_errors_are_listed_from_100_to_300_ms():
    farther = GAP.model_copy(update={"horizons_ms": (100, 200, 310)})
    for gap, listed in ((GAP, [100, 200, 300]), (farther, [100, 200])):
        rows = error_table([diagnosed(verdict(gap=gap))])
        assert rows["horizon_ms"].tolist() == listed
    last = error_table(three_splits()).iloc[-1][ERRORS]
    assert last.tolist() == [300, 40.0, 36.0, 45.0, 12.0, 10.5, 14.0, 11.0]


def test_stability_counts_the_splits_with_a_cause_if_any_has_one():
    none = diagnosed(verdict("no_gap", ()), simulator_name="other")
    rows = stability_table([*three_splits(), none]).set_index("cause")
    assert rows["found"].tolist() == pytest.approx([2, 1, np.nan], nan_ok=True)
    assert rows["splits"].tolist() == [3, 3, 1]
    mine = "1 named, 1 ambiguous, 1 no_gap"
    assert rows["verdicts"].tolist() == [mine, mine, "1 no_gap"]
    wind = rows.loc["wind.x"]
    assert wind[["estimate", "lowest", "highest"]].tolist() == pytest.approx([0.63, 0.61, 0.65])
    assert "estimate" in cause_table([none]) and len(stability_table([none])) == 1
