"""Tables of policies, from small reports."""

import pandas as pd

from rallygap.pipeline.documentation.transfer_tables import (
    both_readings,
    real_swap,
    shot_quality,
    sim2sim_returns,
    spread_policies,
)
from rallygap.pipeline.io.artifacts import write_csv


def test_returns_are_shares_and_their_difference_is_in_points(tmp_path):
    setting = {"protocol": "first_state", "simulator": "imperfect_a", "horizons_ms": "115-125"}
    rates = [
        {**setting, "predictor": "ground_truth", "return_rate": 0.954},
        {**setting, "predictor": "imperfect", "return_rate": 0.803},
    ]
    gain = {**setting, "difference": 0.151, "ci_low": 0.1004, "ci_high": 0.2}
    write_csv(tmp_path / "reports/paper/sim2sim/return_rate.csv", pd.DataFrame(rates))
    write_csv(tmp_path / "reports/paper/sim2sim/difference.csv", pd.DataFrame([gain]))
    assert sim2sim_returns(tmp_path, "paper/").splitlines()[2:] == [
        "| first_state | simulator A | 115-125 | 95 | 80 | 15 (10 to 20) |"
    ]


def test_gains_of_the_transformer_are_shown_under_both_readings(tmp_path):
    shots = {"set": "receive", "horizons_ms": "115-125", "protocol": "every_tick"}
    predictors = ["physics", "transformer", "amended", "oracle", "physics"]
    rates = pd.DataFrame({**shots, "predictor": predictors})
    rates["return_rate"] = [0.57, 0.63, 0.62, 0.6, 0.33]
    rates.loc[4, "protocol"] = "first_window"
    gain = pd.DataFrame({**shots, "predictor": predictors[:4], "outcome": "returns"})
    folder = tmp_path / "reports/run/sim2real"
    write_csv(folder / "rates.csv", rates)
    for name, points in (("difference_first_window", 0.3), ("difference", 0.06)):
        gains = gain.assign(difference=points, ci_low=points - 0.1, ci_high=points + 0.1)
        gains.loc[gains["predictor"] != "transformer", "difference"] = 9.0
        write_csv(folder / f"{name}.csv", gains)
    assert both_readings(tmp_path, "run/").splitlines()[2:] == [
        "| receive | 115-125 | 33 | 57 | 63 | 62 | 60 | 30 (20 to 40) | 6 (-4 to 16) |"
    ]


def test_measured_shots_leave_out_those_of_the_arena(tmp_path):
    of_both = {"horizons_ms": "115-125", "protocol": "every_tick"}
    rates = pd.DataFrame({"set": "tt3d", "predictor": ["physics", "transformer_fine_tuned"]})
    rates = rates.assign(**of_both, returns=[11.0, 13.0], balls=16)
    gains = pd.DataFrame({"set": ["tt3d", "stroke_pro"], "predictor": "transformer_fine_tuned"})
    gains = gains.assign(
        **of_both, outcome="returns", difference=0.125, ci_low=-0.002, ci_high=0.25
    )
    write_csv(tmp_path / "reports/real/sim2real/rates.csv", rates)
    write_csv(tmp_path / "reports/real/sim2real/difference.csv", gains)
    assert real_swap(tmp_path).splitlines()[2:] == [
        "| tt3d, 16 | 115-125 | 11 | 13 | 12 (0 to 25) |"
    ]


def test_shot_quality_has_medians_at_the_nearer_horizons(tmp_path):
    metrics = {"speed": 5.44, "spin": 67.3, "clearance": 0.201, "win_probability": 0.104}
    ends = {f"{name}_{end}": value for name, value in metrics.items() for end in ("low", "high")}
    one = {"set": "receive", "predictor": "oracle", "protocol": "every_tick", "returns": 25.0}
    near, far = ({**one, "horizons_ms": ms, **metrics, **ends} for ms in ("115-125", "170-180"))
    write_csv(tmp_path / "reports/shots/shot_quality/quality.csv", pd.DataFrame([near, far]))
    rows = shot_quality(tmp_path).splitlines()[2:]
    assert rows == [
        "| receive | oracle | every control step | 25 | 5.4 (5.4 to 5.4) | 67 (67 to 67) "
        "| 0.20 (0.20 to 0.20) | 0.10 (0.10 to 0.10) |"
    ]


def test_policies_that_observe_spreads_have_a_difference_to_those_that_do_not(tmp_path):
    one = {"set": "stroke_pro", "predictor": "transformer"}
    kinds = {"exact": 0.8, "filtered": 0.7, "filtered_with_spread": 0.75}
    rates = pd.DataFrame({**one, "policy": kinds.keys(), "return_rate": kinds.values()})
    gains = pd.DataFrame({**one, "outcome": ["hits", "returns"], "difference": [0.5, 0.05]})
    gains = gains.assign(policy="filtered_with_spread", ci_low=-0.001, ci_high=0.09)
    write_csv(tmp_path / "reports/spread_policies.csv", rates)
    write_csv(tmp_path / "reports/spread_policies_differences.csv", gains)
    assert spread_policies(tmp_path).splitlines()[2:] == [
        "| stroke_pro | transformer | 80 | 70 | 75 | 5 (0 to 9) |"
    ]
