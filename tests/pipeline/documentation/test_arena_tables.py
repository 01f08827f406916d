"""Tables of fresh arenas count over all of them."""

import pandas as pd

from rallygap.pipeline.documentation.arena_tables import (
    arena_causes_found,
    arena_coverage,
    arena_coverage_share,
    arena_errors,
)
from rallygap.pipeline.io.artifacts import write_csv
from tests.pipeline.experiments.arenas.made_up import CAUSES, ERRORS


def test_causes_have_a_row_a_size(tmp_path):
    write_csv(tmp_path / "reports/arenas/causes.csv", CAUSES.assign(seed=5))
    lines = arena_causes_found(tmp_path).splitlines()
    assert "| hidden, above 4 | 2 of 2 | 100 (34 to 100) |" in lines
    assert "| hidden, 1 to 2 | 0 of 0 | – |" in lines
    assert "| named, but not hidden | 1 of 4 | 25 (5 to 70) |" in lines
    assert arena_coverage_share(tmp_path) == "2 of 4 (50 %)"


def test_intervals_are_counted_by_whether_a_similar_difference_is_named(tmp_path):
    tilt = pd.DataFrame(
        [("table_tilt", "x", None, None, None, None, 0.002, 0.003)], columns=CAUSES.columns
    )
    named = tilt.assign(low=0.001, high=0.003)
    arenas = {1: tilt, 2: named, 3: tilt.iloc[:0]}  # in the third there is no tilt
    each = [pd.concat([CAUSES, one]).assign(seed=seed) for seed, one in arenas.items()]
    write_csv(tmp_path / "reports/arenas/causes.csv", pd.concat(each))
    lines = arena_coverage(tmp_path).splitlines()
    expected = "| wind.x | table_tilt.x | 0 of 1: 0 (0 to 79) % | 0 of 1: 0 (0 to 79) % |"
    assert expected in lines


def test_errors_are_medians_over_arenas(tmp_path):
    each = [
        ERRORS.assign(seed=seed, mean=ERRORS["mean"] + 10.0 * seed * (ERRORS["mean"] == 24.0),
                      horizon_ms=horizon)
        for seed in (0, 1, 2) for horizon in (100, 200, 300)
    ]  # fmt: skip
    write_csv(tmp_path / "reports/arenas/errors.csv", pd.concat(each))
    lines = arena_errors(tmp_path).splitlines()
    assert lines[4] == f"| transformer |{' 1.50 (1.50 to 1.50) |' * 3}"
    assert lines[6] == f"| simulator C, amended |{' 1.70 (1.20 to 2.20) |' * 3}"
    assert lines[7] == f"| removable gap to the oracle closed (%) |{' 77 (60 to 93) |' * 3}"
