"""The results that the report page opens with are those that a run has."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.io.artifacts import write_csv
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.report.results import RESULTS, results_section

GAP = {"source": "arena", "simulator": "imperfect_c", "before_mm": 80.4, "after_mm": 30.2}
FORECAST = {"set": "tt3d", "quantity": "position", "bounce": "all", "horizon_ms": 300}
EXAM = {
    "distinguishable_right": 7, "distinguishable": 8, "pairs_right": 2, "pairs": 3,
    "false_alarms": 0, "clean_sets": 9,
}  # fmt: skip


@pytest.fixture
def run(tmp_path):
    """Reports with numbers for every result but the learning curves."""
    policies = pd.DataFrame({"predictor": ["physics_c", "transformer", "amended"]})
    policies = policies.assign(observation="intercept", horizons_ms="115-125")
    for column, shift in (("rate", 0.0), ("rate_low", -0.1), ("rate_high", 0.1)):
        policies[f"return_{column}"] = shift + np.array([0.4, 0.5, 0.6])
    protocols = ("first_window", "every_tick")
    tables = {
        "swap_study/readings_all.csv": pd.concat(
            [policies.assign(protocol=protocol) for protocol in protocols]
        ),
        "exam/rates.csv": [{"rate": name, "rallygap": count} for name, count in EXAM.items()],
        "close_gap/errors.csv": [{**GAP, "horizon_ms": 300, "floor_mm": 29.0}],
        "real_forecasts/errors.csv": [
            {**FORECAST, "predictor": "physics_literature", "mean": 100.2},
            {**FORECAST, "predictor": "hybrid_ensemble", "mean": 60.1},
        ],
    }
    for name, rows in tables.items():
        write_csv(tmp_path / name, pd.DataFrame(rows))
    return Reports(tmp_path, {})


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("swap", "40, 50 and 60 % with a forecast at every control step (95 % intervals: at most"),
        ("gap", "simulator C on held-out shots of the arena, 300 ms ahead, is 80 mm before and 30"),
        ("real", "tt3d 100 to 60 mm"),
        ("exam", "7 of 8 distinguishable hidden effects of three detection limits are named"),
    ],
)
def test_a_result_says_what_the_reports_have(run, key, words):
    _, sentence, _ = RESULTS[key]
    assert words in sentence(run)


def test_results_that_lack_a_number_are_left_out(run):
    figures = {figure for _, _, figure in RESULTS.values()}
    for figure in figures:
        (run.folder / figure).parent.mkdir(parents=True, exist_ok=True)
        (run.folder / figure).write_bytes(b"\x89PNG\r\n\x1a\n")
    (run.folder / "swap_study/readings_all.csv").unlink()
    write_csv(run.folder / "exam/rates.csv", pd.DataFrame([{"rate": "pairs", "rallygap": 3}]))
    assert [one["key"] for one in results_section(run, figures)] == ["gap", "real"]
