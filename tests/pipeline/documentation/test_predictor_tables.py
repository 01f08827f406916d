"""Tables of predictors, from small reports."""

import pandas as pd
import pytest

from rallygap.pipeline.documentation.predictor_tables import (
    learning_curves,
    measured_coverage,
    measured_differences,
    paper_network,
    paper_network_short,
)

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


def test_the_network_of_the_papers_size_is_compared_with_the_smaller_one(write):
    one = {"quantity": "position", "bounce": "all", **INTERVAL}
    rows = [
        {**one, "predictor": name, "horizon_ms": 100 * k, "mean": mean + k}
        for name, mean in (("paper_network", 30.0), ("transformer", 20.0), ("oracle", 10.0))
        for k in (3, 1, 2)
    ]
    write("paper_network.csv", *rows)
    pairs = [
        {**one, "predictor": "paper_network", "other": other, "horizon_ms": 100 * k, "mean": 10.0}
        for other in ("transformer", "oracle")
        for k in (1, 2, 3)
    ]
    root = write("paper_network_differences.csv", *pairs)
    interval = "(20.6 to 30.2)"
    assert paper_network(root).splitlines()[2:] == [
        f"| transformer | 21.0 {interval} | 22.0 {interval} | 23.0 {interval} |",
        f"| transformer of the paper's size | 31.0 {interval} | 32.0 {interval} "
        f"| 33.0 {interval} |",
        f"| difference | 10.0 {interval} | 10.0 {interval} | 10.0 {interval} |",
    ]
    assert "is 33 mm, that of the smaller transformer 23 mm" in paper_network_short(root)


def test_a_predictor_that_nobody_has_labelled_has_its_name(write):
    row = {"predictor": "my_network", "recordings": 10, "horizon_ms": 300, "mean": 25.4, **INTERVAL}
    root = write("learning_curves.csv", {**row, "of_oracle": 1.5})
    assert learning_curves(root).splitlines()[-1] == "| my network | 25 (21 to 30) | 1.50 |"
