"""The measured effects that the deviations name are those of the committed runs."""

import json
from pathlib import Path

import pandas as pd
import pytest

from pipeline.params import read_yaml

ROOT = Path(__file__).parents[1]
REPORTS = ROOT / "reports"
DEVIATIONS = (ROOT / "docs/deviations.md").read_text(encoding="utf-8")
DECISIONS = " ".join((ROOT / "docs/decisions.md").read_text(encoding="utf-8").split())
MEASURED = ["isr_ball_prediction", "spindoe", "tt3d"]
ARENA = ["stroke_pro", "stroke_uni", "receive"]


def position_errors(run=".", against="measured", bounce="all"):
    """Mean position errors at 300 ms (mm), by set and predictor."""
    errors = pd.read_csv(REPORTS / run / "evaluate_predictor/forecast_error.csv")
    chosen = errors.query("against == @against and quantity == 'position' and bounce == @bounce")
    return chosen.query("horizon_ms == 300").set_index(["set", "predictor"])["mean"]


def swap_gains(run, predictor, outcome="returns", protocol="every_tick"):
    """What a predictor gains over physics (percentage points), by set and horizons."""
    table = pd.read_csv(REPORTS / run / "sim2real/difference.csv").set_index(["set", "horizons_ms"])
    chosen = table.query(
        "predictor == @predictor and outcome == @outcome and protocol == @protocol"
    )
    return 100 * chosen[["difference", "ci_low", "ci_high"]]


def ends(values, places=0):
    """The smallest and the largest."""
    return f"{values.min():.{places}f} to {values.max():.{places}f}"


def listed(values, places=0):
    """Values as the prose lists them."""
    *first, last = (f"{value:.{places}f}" for value in values)
    return f"{', '.join(first)} and {last}"


def of_the_arena_alone():
    learned = position_errors("real").xs("transformer", level="predictor")[MEASURED]
    return f"off by {listed(learned)} mm at 300 ms on isr_ball_prediction, spindoe and tt3d"


def of_the_better_physics():
    physics = position_errors("real").unstack()[["physics_c", "physics_literature"]]
    better = physics.min(axis=1)[MEASURED]
    return f"the better of two sets of constants by {listed(better)} (`reports/real`)"


def of_fine_tuning():
    tuned = position_errors("real").xs("transformer_fine_tuned", level="predictor")[MEASURED]
    shots = pd.read_csv(REPORTS / "real/segment/splits.csv").query("split == 'train'")
    used = shots[shots["source"].isin(MEASURED)]["episodes"]
    return f"fine-tuned on {ends(used)} measured shots a set: {listed(tuned)} mm"


def of_unbroken_episodes():
    sets = json.loads((REPORTS / "real/segment/metrics.json").read_text())
    shares = 100 * pd.Series({name: one["unbroken_share"] for name, one in sets.items()})
    measured = ends(shares[MEASURED])
    return f"{shares['arena']:.0f} % of the arena's episodes are unbroken, {measured} %"


def of_bounces():
    within, without = (position_errors(bounce=name)["arena"] for name in ("with", "without"))
    ours, oracle = (
        [f"{one[name]:.0f}" for one in (within, without)] for name in ("transformer", "oracle")
    )
    transformer = f"{ours[0]} mm with a bounce, {ours[1]} without (transformer)"
    return f"at 300 ms {transformer}, {oracle[0]} and {oracle[1]} (oracle)"


def of_the_truth():
    measured, true = (
        position_errors(against=name)["arena", "transformer"] for name in ("measured", "truth")
    )
    return f"at 300 ms {measured:.1f} mm against the measured state, {true:.1f} against the true"


def of_constants():
    found = position_errors()["arena"]
    return (
        f"{found['physics_c']:.0f} mm with simulator C, {found['physics_literature']:.0f} with the "
        f"literature's constants, {found['amended_imperfect_c']:.0f} with C amended by training "
        f"balls, {found['oracle']:.0f} with the hidden physics"
    )


def of_passes():
    long, short = position_errors("real")["arena"], position_errors()["arena"]
    change = {name: f"{long[name]:.1f} to {short[name]:.1f}" for name in short.index}
    return (
        f"{change['transformer']} mm at 300 ms (transformer), {change['tae']} (`tae`), "
        f"{change['gru_tae']} (`gru_tae`)"
    )


def of_more_balls():
    found = position_errors("paper")["arena"][["transformer", "tae", "gru_tae"]]
    return "With the paper's number of balls it is " + ", ".join(f"{mean:.0f}" for mean in found)


def policies(run, group):
    """Return rates of policies of a group in simulator C (%)."""
    table = pd.read_csv(REPORTS / run / "train_policy/policies.csv")
    chosen = table.query("group == @group and simulator == 'imperfect_c'")
    return 100 * chosen.set_index("horizons_ms")["return_rate"]


def of_longer_training():
    short, long = (policies(run, "sim2sim") for run in (".", "policies"))
    before, after = (ends(rates).replace(" to ", "-") for rates in (short, long))
    return f"simulator C: {before} % (`reports/train_policy`) to {after} % (`reports/policies`)"


def of_what_policies_see():
    strict, intercept = (ends(policies("policies", name), 1) for name in ("strict", "sim2sim"))
    return f"`strict` returns {strict} %, `intercept` {intercept} %"


def of_seeds():
    rates = policies("policies", "sim2sim")["115-125"]
    return f"three seeds of one setting: {ends(rates, 1)} %"


def of_desired_skills():
    shots, landings = (
        pd.read_csv(REPORTS / run / "train_policy/policies.csv").query("group == 'sim2sim'")
        for run in ("shots", "policies")
    )
    slopes = shots.groupby("horizons_ms")[["speed_slope", "topspin_slope"]].mean().stack()
    asked, alone = (table["landing_error_m"].mean() for table in (shots, landings))
    text = f"slopes of {ends(slopes, 2)}, and landings {asked:.2f} m from the goal in place of "
    return (text + f"{alone:.2f}").replace("0.", ".")


def of_the_right_simulator():
    gains = pd.read_csv(REPORTS / "sim2sim/difference.csv").set_index("protocol")["difference"]
    first, anew = (ends(100 * gains[name]) for name in ("first_state", "re_anchored"))
    return f"gains {first} points from the first state, {anew} anew at every tick"


def of_the_first_window():
    lost = -swap_gains(".", "physics", protocol="first_window")["difference"]
    return f"from the first window alone physics returns {ends(lost)} points fewer"


def of_the_swap_on_measured_sets():
    gains = swap_gains("real", "transformer_fine_tuned").loc[MEASURED]
    assert not (gains["ci_low"].gt(0) | gains["ci_high"].lt(0)).any()
    change = ends(gains["difference"])
    return f"the fine-tuned transformer gains {change} points of returns, no interval clear of zero"


def clear_on_the_arena(run, predictor):
    """The intervals of six that are clear of zero."""
    gains = swap_gains(run, predictor).loc[ARENA]
    clear = gains[gains["ci_low"].gt(0) | gains["ci_high"].lt(0)]
    assert len(gains) == 6
    rows = [f"{row[0]:.1f} points ({row[1]:.1f} to {row[2]:.1f})" for row in clear.to_numpy()]
    return ", ".join(rows) or "none"


def of_the_swap_on_the_arena():
    laptop, paper = (clear_on_the_arena(run, "transformer") for run in (".", "paper"))
    real = clear_on_the_arena("real", "transformer_fine_tuned")
    counts = (
        f"in `laptop` {laptop}, in `reports/paper` {paper}, fine-tuned in `reports/real` {real}"
    )
    return f"of six intervals clear of zero: {counts}"


def of_reach():
    shots = pd.read_csv(REPORTS / "sim2real/replayed.csv").set_index("set").loc[ARENA]
    counts = [f"{row.in_reach} of {row.replayed}" for row in shots.itertuples()]
    return f"{counts[0]}, {counts[1]} and {counts[2]} are in reach"


def of_the_forest():
    scores = pd.read_csv(REPORTS / "shot_quality/scores.csv").query("outcome == 'wins'")
    areas = scores.set_index("method")["roc_auc"].map("{:.2f}".format).str.lstrip("0")
    return f"ROC-AUC {areas['forest']}, that of a logistic regression {areas['logistic']}"


def of_the_forest_s_label():
    rows = pd.read_csv(REPORTS / "shot_quality/win_probability.csv").query(
        "protocol == 'every_tick' and predictor in ('physics', 'transformer')"
    )
    by_predictor = rows.pivot_table("point", ["set", "horizons_ms"], "predictor")
    apart = (by_predictor["transformer"] - by_predictor["physics"]).abs().max()
    medians = ends(rows["point"], 2)
    return f"medians by it are {medians}, with and without the swap at most {apart:.2f} apart"


def of_the_forest_s_settings():
    forest = read_yaml(ROOT / "params.yaml")["shot_quality"]["forest"]
    return f"{forest['trees']} trees with at least {forest['min_samples_leaf']} shots a leaf"


def precision(measure):
    """A row of what 16 bits cost."""
    rows = pd.read_csv(REPORTS / "costs/precision.csv").set_index("measure")
    return rows.loc[measure]


def of_precision():
    position = precision("position error, 100 to 300 ms (mm)")
    spin = precision("spin error at 300 ms (rad/s)")
    texts = [
        f"{row.difference:.2f} {unit} ({row.ci_low:.2f} to {row.ci_high:.2f})"
        for row, unit in ((position, "mm"), (spin, "rad/s"))
    ]
    return f"16 bits minus 32: {texts[0]} from 100 to 300 ms, {texts[1]} at 300 ms"


@pytest.mark.parametrize(
    "expected",
    [
        of_the_arena_alone,
        of_the_better_physics,
        of_fine_tuning,
        of_unbroken_episodes,
        of_bounces,
        of_the_truth,
        of_constants,
        of_passes,
        of_more_balls,
        of_longer_training,
        of_what_policies_see,
        of_seeds,
        of_desired_skills,
        of_the_right_simulator,
        of_the_first_window,
        of_the_swap_on_measured_sets,
        of_the_swap_on_the_arena,
        of_reach,
        of_the_forest,
        of_the_forest_s_label,
        of_the_forest_s_settings,
        of_precision,
    ],
)
def test_effects_are_those_of_the_committed_runs(expected):
    assert expected() in DEVIATIONS


def test_the_baselines_are_level_after_the_long_training_alone():
    for run, level in (("real", True), (".", False)):
        table = pd.read_csv(REPORTS / run / "evaluate_predictor/forecast_error_difference.csv")
        pair = table.query(
            "set == 'arena' and quantity == 'position' and horizon_ms == 300 "
            "and predictor == 'gru_tae' and other == 'tae'"
        ).iloc[0]
        assert (pair["ci_low"] < 0 < pair["ci_high"]) == level
    assert "the baselines are level after 70 and apart after 32" in DEVIATIONS


def test_what_16_bits_cost_is_told_with_the_row_that_is_clear_of_zero():
    rows = pd.read_csv(REPORTS / "costs/precision.csv")
    clear = rows[rows["ci_low"].gt(0) | rows["ci_high"].lt(0)]
    assert list(clear["measure"]) == ["spin error at 300 ms (rad/s)"]
    spin = clear.iloc[0]
    seeds = [f"{spin[f'seed_{number}']:.2f}".replace("0.", ".") for number in (1, 2, 3)]
    grows = f"{spin['difference']:.2f}".lstrip("0")
    assert f"spin error at 300 ms grows by {grows} rad/s" in DECISIONS
    assert f"by seed {seeds[0]}, {seeds[1]} and {seeds[2]}" in DECISIONS
