"""Tables of predictors, from small reports."""

import pandas as pd
import pytest

from pipeline.documentation.predictor_tables import (
    learning_curves,
    measured_coverage,
    measured_differences,
)
from pipeline.documentation.transfer_tables import spread_policies

INTERVAL = {"ci_low": 20.6, "ci_high": 30.2}


@pytest.fixture
def write(tmp_path):
    (tmp_path / "reports/real").mkdir(parents=True)

    def written(name, *rows):
        pd.DataFrame(rows).to_csv(tmp_path / "reports" / name, index=False)
        return tmp_path

    return written


def test_learning_curves_have_a_column_a_number_of_recordings(write):
    one = {"predictor": "oracle", "horizon_ms": 300, "mean": 25.0, **INTERVAL}
    rows = [{**one, "recordings": size, "of_oracle": size / 1000} for size in (1000, 30)]
    root = write("learning_curves.csv", *rows, {**rows[0], "horizon_ms": 100, "mean": 9.0})
    lines = learning_curves(root).splitlines()
    assert (
        lines[0] == "| predictor | 30 recordings | 1,000 recordings | error with all / oracle's |"
    )
    assert lines[2:] == ["| oracle | 25 (21 to 30) | 25 (21 to 30) | 1.00 |"]


def test_coverage_on_measured_sets_is_that_at_200_ms(write):
    one = {"set": "tt3d", "predictor": "amended", "horizon_ms": 200, "size_mm": 31.2}
    low = {**one, "level": 0.5, "coverage": 0.49, "ci_low": 0.44, "ci_high": 0.53, "crps_mm": 12.3}
    high = {**low, "level": 0.9, "coverage": 0.91, "ci_low": 0.87, "ci_high": 0.94}
    root = write("real/forecast_coverage.csv", high, low, {**low, "horizon_ms": 100})
    assert measured_coverage(root).splitlines()[2:] == [
        "| tt3d | physics, literature amended | 49.0 (44.0 to 53.0), 31 | 91.0 (87.0 to 94.0), 31 "
        "| 12.3 |"
    ]


def test_differences_on_measured_sets_are_those_of_the_hybrid(write):
    one = {"set": "tt3d", "predictor": "hybrid", "other": "transformer"}
    rows = [
        {**one, "quantity": "position", "horizon_ms": 100 * k, "mean": -k, "ci_low": -k - 1.0,
         "ci_high": 0.0}
        for k in (1, 2, 3)
    ]  # fmt: skip
    root = write("real/forecast_differences.csv", *rows, {**rows[0], "other": "amended"})
    assert measured_differences(root).splitlines()[2:] == [
        "| tt3d | hybrid on the amended simulator | transformer | -1.0 (-2.0 to 0.0) "
        "| -2.0 (-3.0 to 0.0) | -3.0 (-4.0 to 0.0) |"
    ]


def test_policies_that_observe_spreads_have_a_difference_to_those_that_do_not(write):
    one = {"set": "stroke_pro", "predictor": "transformer"}
    kinds = {"exact": 0.8, "filtered": 0.7, "filtered_with_spread": 0.75}
    write(
        "spread_policies.csv", *({**one, "policy": k, "return_rate": v} for k, v in kinds.items())
    )
    gain = {**one, "policy": "filtered_with_spread", "difference": 0.05}
    gains = [
        {**gain, "outcome": name, "ci_low": 0.01, "ci_high": 0.09} for name in ("hits", "returns")
    ]
    root = write("spread_policies_differences.csv", *gains)
    assert spread_policies(root).splitlines()[2:] == [
        "| stroke_pro | transformer | 80 | 70 | 75 | 5 (1 to 9) |"
    ]
