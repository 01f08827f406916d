"""The table of sweeps, from small reports."""

from pipeline.documentation.sweep_tables import committed_sweeps
from pipeline.io.artifacts import write_json


def test_only_a_sweep_with_a_better_trial_has_a_confirmation(tmp_path):
    sweep = {
        "sweep": "policy",
        "score": "return rate",
        "trials": {"completed": 12, "pruned": 8},
        "params_score": 0.85,
        "best_score": 0.9,
    }
    confirmed = {
        "measure": "return rate",
        "params": 0.8157,
        "found": 0.818,
        "difference": 0.0023,
        "ci_low": -0.0143,
        "ci_high": 0.019,
        "holds": False,
    }
    reports = tmp_path / "reports" / "sweeps"
    write_json(reports / "policy" / "sweep.json", sweep)
    write_json(reports / "policy" / "confirmed.json", confirmed)
    unconfirmed = {**sweep, "sweep": "predictor", "trials": {"completed": 30}, "params_score": None}
    write_json(reports / "predictor" / "sweep.json", unconfirmed)
    assert committed_sweeps(tmp_path).splitlines()[2:] == [
        "| `policy` | 20 (8) | return rate | 0.85 | 0.9 | return rate | 0.8157 | 0.818 "
        "| 0.002 (-0.014 to 0.019) | no |",
        "| `predictor` | 30 (0) | return rate | – | 0.9 | – | – | – | – | – |",
    ]
