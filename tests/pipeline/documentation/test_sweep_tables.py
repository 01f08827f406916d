"""Tables of sweeps, from small reports."""

from rallygap.pipeline.documentation.sweep_tables import committed_sweeps, confirmed_sweeps
from rallygap.pipeline.io.artifacts import write_json

SWEEP = {
    "sweep": "policy",
    "score": "return rate",
    "trials": {"completed": 12, "pruned": 8},
    "params_score": 0.85,
    "best_score": 0.9,
}


def test_params_outside_the_space_have_no_score(tmp_path):
    write_json(tmp_path / "reports/sweeps/policy/sweep.json", SWEEP)
    other = {**SWEEP, "sweep": "predictor", "trials": {"completed": 30}, "params_score": None}
    write_json(tmp_path / "reports/sweeps/predictor/sweep.json", other)
    assert committed_sweeps(tmp_path).splitlines()[2:] == [
        "| `policy` | 20 | 8 | return rate | 0.85 | 0.9 |",
        "| `predictor` | 30 | 0 | return rate | – | 0.9 |",
    ]


def test_only_confirmed_sweeps_have_a_confirmation(tmp_path):
    write_json(tmp_path / "reports/sweeps/predictor/sweep.json", SWEEP)
    confirmed = {
        "sweep": "policy",
        "measure": "return rate",
        "params": 0.8157,
        "found": 0.818,
        "difference": 0.0023,
        "ci_low": -0.0143,
        "ci_high": 0.019,
        "holds": False,
    }
    write_json(tmp_path / "reports/sweeps/policy/confirmed.json", confirmed)
    assert confirmed_sweeps(tmp_path).splitlines()[2:] == [
        "| `policy` | return rate | 0.8157 | 0.818 | 0.002 (-0.014 to 0.019) | no |"
    ]
