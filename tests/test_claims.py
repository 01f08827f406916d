"""What README and the results pages say in numbers, outside their tables, holds for the reports."""

import re
from pathlib import Path

import pandas as pd
import pytest

from experiments.arena_scores import found_by_size, ratios, scored
from rallygap.models.ball import state
from rallygap.pipeline.io.artifacts import read_json

REPORTS = Path(__file__).parents[1] / "reports"
MEASURED = ["isr_ball_prediction", "spindoe", "tt3d"]


def table(name, query=""):
    rows = pd.read_csv(REPORTS / f"{name}.csv")
    return rows.query(query) if query else rows


def returns(name, query=""):
    """The least and largest difference in points, how many are significant, and of how many."""
    rows = table(name, f"outcome == 'returns'{query and ' and ' + query}")
    points = (100 * rows["difference"]).round()
    return points.min(), points.max(), (rows["p_holm"] < 0.05).sum(), len(rows)


def test_the_arena():
    errors = table("close_gap/errors", "source == 'arena' and horizon_ms == 300").iloc[0]
    assert errors[["before_mm", "after_mm"]].round().tolist() == [66, 24]
    curves = table("learning_curves/errors", "horizon_ms == 300")
    means = curves.pivot(index="recordings", columns="predictor", values="mean")
    assert (means.loc[300:, "amended_imperfect_c"].round() == 28).all()
    assert (means["amended_imperfect_c"] < means["transformer"]).all()
    assert (means["amended_imperfect_c"] < means["hybrid"]).loc[300:].all()
    assert means["transformer"].iloc[-1].round() == 40
    errors = table("evaluate_predictor/forecast_error", "set == 'arena' and against == 'measured'")
    errors = errors.query("quantity == 'position' and bounce == 'all' and horizon_ms == 300")
    with_net = errors.set_index("predictor").loc["physics_c_with_net", "mean"]
    assert (means["transformer"] < with_net).loc[300:].all()
    assert (means["hybrid"] < with_net).all()


def test_twenty_arenas():
    causes, errors = table("arenas/causes"), table("arenas/errors")
    found = [counts for _, *counts in found_by_size(causes)]
    assert found == [[34, 73], [63, 64], [59, 59], [104, 104], [40, 40]]
    named = scored(causes).query("named")
    assert (len(named), named["covered"].sum(), (~named["hidden"]).sum()) == (300, 268, 0)
    rivals = ["imperfect_c", "imperfect_c_with_net", "transformer", "hybrid", "amended"]
    medians = [round(ratios(errors, name, 300).median(), 2) for name in rivals]
    assert medians == [2.64, 2.18, 1.33, 1.10, 0.98]
    before, after = (ratios(errors, name, 300) for name in ("imperfect_c", "amended"))
    assert ((before - after) / (before - 1)).median() > 1  # of the removable error


def test_the_exam():
    exam = table("exam/rates").set_index("rate")["rallygap"]
    names = ["trials", "distinguishable_right", "pairs_right", "false_alarms", "withheld_right"]
    assert [exam[name] for name in names] == [1816, 147, 76, 3, 21]
    names = ["distinguishable", "pairs", "clean_sets", "withheld"]
    assert [exam[name] for name in names] == [152, 77, 500, 37]


def test_measured_sets():
    errors = table("real/close_gap/errors", "simulator == 'imperfect_c' and horizon_ms == 200")
    means = errors.groupby("source")[["before_mm", "after_mm"]].mean().round().loc[MEASURED]
    assert means.to_numpy().tolist() == [[31, 35], [130, 99], [81, 65]]
    verdicts = table("real/close_gap/verdicts").set_index("source").loc[MEASURED]
    changes = pd.DataFrame(
        {"better": verdicts["reduction_low_mm"] > 0, "worse": verdicts["reduction_high_mm"] < 0}
    )
    assert changes.groupby(level=0).sum().to_numpy().tolist() == [[0, 2], [7, 0], [6, 0]]
    leading = table("real/close_gap/causes", f"role == 'leading' and source in {MEASURED}")
    assert not leading["cause"].str.startswith("gravity").any()
    splits = leading.groupby(["source", "simulator", "cause"]).size()
    assert (int((splits == 3).sum()), len(splits)) == (21, 68)


def test_planted_errors():
    scores = pd.DataFrame(read_json(REPORTS / "known_answers" / "scores.json")).T
    names = ["leading", "questions", "unplanted_clean", "unplanted"]
    assert scores[names].sum().tolist() == [97, 110, 1, 6]


def test_scenes_of_other_engines():
    scenes = read_json(REPORTS / "simulators" / "scenes.json")
    counts = {
        engine: (sum(case["named_right"] for case in cases.values()), len(cases))
        for engine, cases in scenes.items()
    }
    assert counts == {"mujoco": (13, 14), "pybullet": (4, 4)}


def test_forecasts_on_measured_sets():
    rows = table("real_forecasts/errors", "quantity == 'position' and bounce == 'all'")
    means = rows.pivot(index=["set", "horizon_ms"], columns="predictor", values="mean")
    best = means.idxmin(axis=1)
    best = best.drop(("isr_ball_prediction", 100))
    assert set(best) == {"hybrid_ensemble"}
    assert means["hybrid_ensemble"].round().xs(200, level=1).loc[MEASURED].tolist() == [9, 69, 38]
    covered = table("real_forecasts/coverage", "level == 0.9 and horizon_ms == 200")["coverage"]
    assert covered.between(0.887, 0.908).all()


@pytest.mark.parametrize(
    ("name", "query", "expected"),
    [
        ("gains", "protocol == 'first_window' and predictor == 'transformer'", (-2, 2, 0, 4)),
        ("gains", "protocol == 'first_window' and predictor == 'amended'", (8, 12, 3, 4)),
        ("gains", "protocol == 'every_tick' and predictor == 'transformer'", (-1, 0, 0, 4)),
        ("gains", "protocol == 'every_tick' and predictor == 'oracle'", (1, 1, 0, 4)),
        ("gains_every_tick", "predictor == 'physics_c'", (15, 17, 4, 4)),
        ("gains_retrained", "", (-2, 2, 0, 16)),
    ],
)
def test_the_swap_study(name, query, expected):
    assert returns(f"swap_study/{name}", query) == expected


def test_returns_in_other_simulators_and_runs():
    for run, gained in (("", 18), ("paper/", 12)):
        gains = table(f"{run}sim2sim/difference")
        first, again = (gains[gains["protocol"] == name] for name in ("first_state", "re_anchored"))
        assert (first["p_holm"] < 0.05).all()
        assert (100 * first["difference"]).min() >= gained
        assert again["difference"].between(-0.031, 0.021).all()
    query = "protocol == 'every_tick' and outcome == 'returns' and predictor != 'physics'"
    assert (table("paper_physics/sim2real/difference", query)["p_holm"] > 0.05).all()
    query = "predictor == 'transformer_fine_tuned' and not set.str.match('stroke|receive')"
    measured = table("real/sim2real/difference", f"{query} and outcome == 'returns'")
    assert (measured["p_holm"] > 0.05).all()
    latent = table("swap_study/mechanism", "latency_ms == 100")
    assert latent["return_rate"].max() < 0.045
    query = "outcome == 'returns' and policy == 'filtered_with_spread'"
    spread = table("spread_policies/differences", query)
    assert ((spread["ci_low"] <= 0) & (spread["ci_high"] >= 0)).all()


def test_forecasts_in_other_runs():
    query = "set == 'arena' and against == 'measured' and quantity == 'position'"
    expected = {
        "paper": {"transformer": 33, "hybrid": 29, "amended_imperfect_c": 27},
        "paper_physics": {"physics_c": 72, "amended_imperfect_c": 28, "transformer": 40},
    }
    for run, errors in expected.items():
        rows = table(f"{run}/evaluate_predictor/forecast_error", query)
        rows = rows.query("bounce == 'all' and horizon_ms == 300").set_index("predictor")
        assert rows["mean"].round()[list(errors)].to_dict() == errors


def test_the_papers_network():
    query = "quantity == 'position' and bounce == 'all' and horizon_ms == 300"
    means = table("paper_network/errors", query).set_index("predictor")["mean"].round()
    assert means[["paper_network", "transformer"]].tolist() == [37, 33]


def test_what_it_costs():
    minutes = read_json(REPORTS / "costs" / "reproduce.json")["seconds"] / 60
    assert minutes == pytest.approx(46, abs=0.5)
    sizes = read_json(REPORTS / "costs" / "scale.json")
    gigabytes = [1e7 * sizes[name] / 1e9 for name in ("disk_bytes", "memory_bytes")]
    assert gigabytes == pytest.approx([238, 337], abs=0.5)


def test_the_papers_claims():
    from experiments.report.paper_page import compared_runs
    from rallygap.pipeline.paper.comparison import exhibits

    runs = compared_runs(REPORTS.parent).values()
    words = {figure.name: [figure.assessment(run) for run in runs] for figure in exhibits()}
    assert words["Figure 3"][:2] == ["open", "holds"]
    assert words["Figure 4"][:2] == ["holds", "holds"]
    assert {*words["Table I, physics from the first window"]} == {"open"}
    assert words["Figure 5"] == ["not comparable", "not comparable", "fails"]


def test_constants_of_the_ball_and_the_table():
    page = (REPORTS.parent / "docs" / "ball-physics.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([A-Z_]+)` \|.*?\| ([\d.e-]+) \|", page, re.MULTILINE)
    assert len(rows) == 11
    for name, value in rows:
        assert f"{getattr(state, name):.6g}" == value, name
