"""Tables of live forecasts, from small reports."""

from rallygap.pipeline.documentation.live_tables import drift, latency
from rallygap.pipeline.io.artifacts import write_json


def test_a_predictor_that_is_not_compiled_has_no_change(tmp_path):
    times = {"p50_ms": 0.271, "p99_ms": 0.5, "eager_ms": 2.0}
    content = {
        "oracle": {**times, "max_change_mm": None},
        "transformer": {**times, "max_change_mm": 0.123},
    }
    write_json(tmp_path / "reports/live/latency.json", content)
    assert latency(tmp_path).splitlines()[2:] == [
        "| oracle | 0.27 | 0.50 | 2.00 | – |",
        "| transformer | 0.27 | 0.50 | 2.00 | 0.12 |",
    ]


def test_drift_that_is_seldom_named_has_no_median(tmp_path):
    sizes = {
        "1x": {"median_shots": None, "named_right": 0.25},
        "2x": {"median_shots": 38.5, "named_right": 0.9},
    }
    content = {"false_alarms": 1, "shots": 9_630, "causes": {"drag.cd": sizes}}
    write_json(tmp_path / "reports/live/drift.json", content)
    first, _, head, _, row = drift(tmp_path).splitlines()
    assert first == "False alarms: 1 in 9,630 shots without a change."
    assert head == "| changed | 1x: shots, named right | 2x: shots, named right |"
    assert row == "| `drag.cd` | –, 25 % | 38.5, 90 % |"
