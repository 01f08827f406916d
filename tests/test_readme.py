"""The README's numbers are those of the committed runs."""

import json
import re
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
NAMES = {
    "physics_c": "physics, simulator C",
    "physics_literature": "physics, literature",
    "amended_imperfect_c": "physics, C amended",
    "amended_without_magnus": "physics, C without lift amended",
    "amended_from_literature": "physics, literature amended",
    "oracle": "oracle",
    "transformer": "transformer",
    "transformer_fine_tuned": "transformer, fine-tuned",
    "tae": "TAE",
    "tae_fine_tuned": "TAE, fine-tuned",
    "gru_tae": "GRU-TAE",
    "gru_tae_fine_tuned": "GRU-TAE, fine-tuned",
}
TRAININGS = (  # what policies are told of, the experiment that trained them, their group in it
    ("landing", "policies", "sim2sim"),
    ("landing, the paper's inputs alone", "policies", "strict"),
    ("landing, speed and topspin", "shots", "sim2sim"),
)

RATES = (  # what the exam counts, and where its counts are
    ("clean sets with a false alarm", "false_alarms", "clean_sets"),
    ("one effect at 3x, a class of its own: its name", "distinguishable_right", "distinguishable"),
    (
        "one effect at 3x, others look like it: its class",
        "indistinguishable_right",
        "indistinguishable",
    ),
    ("two effects at 3x: both", "pairs_right", "pairs"),
    ("withheld from the catalogue: called unknown", "withheld_right", "withheld"),
    ("95 % intervals that hold the truth", "intervals_right", "intervals"),
)


def expected_table(report, of_arena):
    """Position errors of a run, on the arena or on the measured sets."""
    errors = pd.read_csv(ROOT / report / "evaluate_predictor/forecast_error.csv")
    errors = errors.query("against == 'measured' and quantity == 'position' and bounce == 'all'")
    errors = errors[(errors["set"] == "arena") == of_arena]
    lines = ["| set | predictor | 100 ms | 200 ms | 300 ms |", "|---|---|---|---|---|"]
    for (source, predictor), rows in errors.groupby(["set", "predictor"], sort=False):
        cells = [
            f"{row['mean']:.0f} ({row['ci_low']:.0f} to {row['ci_high']:.0f})"
            for _, row in rows.sort_values("horizon_ms").iterrows()
        ]
        lines.append(f"| {source} | {NAMES[predictor]} | {' | '.join(cells)} |")
    return "\n".join(lines)


def expected_costs():
    """Size, training, latency and position errors of predictors, by ``rallygap costs``."""
    costs = pd.read_csv(ROOT / "reports/costs/costs.csv")
    lines = [
        "| predictor | parameters | training (s) | one ball, median (ms) | 99th percentile (ms) "
        "| mm at 100 ms | at 200 ms | at 300 ms |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in costs.to_dict("records"):
        size, training = (
            f"{row[name]:,.0f}" if pd.notna(row[name]) else "–"
            for name in ("parameters", "training_s")
        )
        times = [f"{row[f'latency_ms_{name}']:.2f}" for name in ("median", "p99")]
        errors = [f"{row[f'position_error_mm_{horizon}ms']:.0f}" for horizon in (100, 200, 300)]
        cells = " | ".join([size, training, *times, *errors])
        lines.append(f"| {NAMES[row['predictor']]} | {cells} |")
    return "\n".join(lines)


def expected_numbers():
    """Numbers of the simulator before and after, beside the arena's, those that shots can show."""
    numbers = pd.read_csv(ROOT / "reports/retrain_policy/numbers.csv").query("source == 'arena'")
    numbers = numbers[~numbers["effect"].isin(["racket_bounce", "net"])]
    numbers = numbers[~(numbers["amended"].fillna(0) == numbers["truth"].fillna(0))]
    lines = ["| effect | number | simulator C | named | the arena |", "|---|---|---|---|---|"]
    for row in numbers.itertuples():
        before, after, truth = (
            f"{value:.4g}" if pd.notna(value) else "–"
            for value in (row.original, row.amended, row.truth)
        )
        named = f"{after} ({row.low:.4g} to {row.high:.4g})" if pd.notna(row.low) else "–"
        lines.append(f"| {row.effect} | {row.parameter} | {before} | {named} | {truth} |")
    return "\n".join(lines)


def expected_exam():
    """Counts of the exam, ours beside those of the methods compared."""
    results = json.loads((ROOT / "reports/hidden_effects/exam.json").read_text(encoding="utf-8"))
    methods = {"rallygap": results, **results["compared"]}
    lines = [f"| | {' | '.join(methods)} |", f"|---|{'---|' * len(methods)}"]
    for name, right, asked in RATES:
        pairs = [(one[right], one[asked]) for one in methods.values()]
        counts = [f"{number} of {whole}" if whole else "–" for number, whole in pairs]
        lines.append(f"| {name} | {' | '.join(counts)} |")
    closed = [f"{100 * one['removable_closed']:.0f}" for one in methods.values()]
    return "\n".join([*lines, f"| removable gap closed (%) | {' | '.join(closed)} |"])


def expected_loop():
    """Returns of all balls of the arena, by policy and predictor."""
    rows = pd.read_csv(ROOT / "reports/retrain_policy/returns.csv").query("set == 'arena'")
    lines = [
        "| policy | told by | horizons (ms) | returns of 150 | difference (points) |",
        "|---|---|---|---|---|",
    ]
    for row in rows.itertuples():
        mean, low, high = (100 * end for end in (row.difference, row.ci_low, row.ci_high))
        gain = f"{mean:.0f} ({low:.0f} to {high:.0f})" if pd.notna(mean) else "–"
        name = f"{row.policy} | {row.predictor} | {row.horizons_ms}"
        lines.append(f"| {name} | {row.returns:.0f} | {gain} |")
    return "\n".join(lines)


def expected_sim2sim(report="reports"):
    """Return rates of a run, and what the ground truth's predictions gain."""
    rates = pd.read_csv(ROOT / report / "sim2sim/return_rate.csv")
    gains = pd.read_csv(ROOT / report / "sim2sim/difference.csv")
    lines = [
        "| protocol | trained in | horizons (ms) | truth | own simulator | difference |",
        "|---|---|---|---|---|---|",
    ]
    for gain in gains.itertuples():
        setting = (gain.protocol, gain.simulator, gain.horizons_ms)
        own = rates.set_index(["protocol", "simulator", "horizons_ms", "predictor"])["return_rate"]
        shares = [100 * own[(*setting, predictor)] for predictor in ("ground_truth", "imperfect")]
        ends = [100 * end for end in (gain.difference, gain.ci_low, gain.ci_high)]
        name = f"{gain.protocol} | {gain.simulator[-1].upper()} | {gain.horizons_ms}"
        mean, low, high = (round(end) for end in ends)
        cells = f"{shares[0]:.0f} | {shares[1]:.0f} | {mean} ({low} to {high})"
        lines.append(f"| {name} | {cells} |")
    return "\n".join(lines)


def expected_real_swap():
    """Returns on measured sets, by physics and by the fine-tuned transformer."""
    report = ROOT / "reports/real/sim2real"
    rates = pd.read_csv(report / "rates.csv").query("protocol == 'every_tick'")
    returns = rates.set_index(["set", "horizons_ms", "predictor"])["returns"]
    gains = pd.read_csv(report / "difference.csv")
    chosen = "outcome == 'returns' and predictor == 'transformer_fine_tuned'"
    lines = [
        "| shots | horizons (ms) | physics C | transformer, fine-tuned | difference (points) |",
        "|---|---|---|---|---|",
    ]
    for gain in gains.query(chosen).itertuples():
        if gain.set.startswith(("stroke", "receive")):
            continue
        setting = (gain.set, gain.horizons_ms)
        balls = rates.set_index(["set", "horizons_ms"])["balls"][setting].iloc[0]
        both = [f"{returns[(*setting, one)]:.0f}" for one in ("physics", gain.predictor)]
        mean, low, high = (round(100 * end) for end in (gain.difference, gain.ci_low, gain.ci_high))
        cells = f"{both[0]} | {both[1]} | {mean} ({low} to {high})"
        lines.append(f"| {gain.set}, {balls} | {gain.horizons_ms} | {cells} |")
    return "\n".join(lines)


def expected_sim2real(report="reports"):
    """Hits and returns of a run and of the paper, as many as the shots of each."""
    shots = pd.read_csv(ROOT / report / "sim2real/transfer.csv")
    lines = [
        "| shots | learned by | horizons (ms) | hits, physics | hits, learned "
        "| returns, physics | returns, learned |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in shots.to_dict("records"):
        for horizons in ("115-125", "170-180"):
            counts = [
                f"{row[f'{horizons} ms: {predictor} {what}']:.0f}"
                for what in ("hits", "returns")
                for predictor in ("physics", "learned")
            ]
            name = f"{row['set']}, {row['shots']} | {row['learned_predictor']} | {horizons}"
            lines.append(f"| {name} | {' | '.join(counts)} |")
    return "\n".join(lines)


def expected_trainings():
    """Returns of the longer trainings, each on unseen balls of its own simulator."""
    lines = [
        "| told of | horizons (ms) | ticks | returns, three seeds | landing error (m) "
        "| slope of speed | slope of topspin |",
        "|---|---|---|---|---|---|---|",
    ]
    for told, experiment, group in TRAININGS:
        policies = pd.read_csv(ROOT / "reports" / experiment / "train_policy/policies.csv")
        own = policies[policies["group"] == group]
        for horizons, rows in own.groupby("horizons_ms", sort=False):
            returns = ", ".join(f"{100 * rate:.1f}" for rate in rows["return_rate"])
            means = rows.mean(numeric_only=True)
            slopes = [
                f"{means[name]:.2f}" if pd.notna(means.get(name)) else "–"
                for name in ("speed_slope", "topspin_slope")
            ]
            cells = f"{means['ticks']:,.0f} | {returns} | {means['landing_error_m']:.2f}"
            lines.append(f"| {told} | {horizons} | {cells} | {' | '.join(slopes)} |")
    return "\n".join(lines)


@pytest.mark.parametrize("expected", [expected_numbers, expected_loop, expected_exam])
def test_the_tables_of_the_gap_are_the_committed_run_s(expected):
    assert expected() in README


@pytest.mark.parametrize(
    "expected", [expected_sim2sim, expected_sim2real, expected_real_swap, expected_trainings]
)
def test_the_tables_of_transfer_are_the_committed_run_s(expected):
    assert expected() in README


@pytest.mark.parametrize("expected", [expected_sim2sim, expected_sim2real])
def test_the_tables_of_transfer_with_the_paper_s_balls_are_the_kept_run_s(expected):
    assert expected("reports/paper") in README


@pytest.mark.parametrize(
    ("report", "of_arena"), [("reports", True), ("reports/real", False), ("reports/paper", True)]
)
def test_the_tables_are_the_committed_runs(report, of_arena):
    assert expected_table(report, of_arena) in README


def test_the_time_of_a_reproduction_is_that_of_one_that_changed_nothing():
    measured = json.loads((ROOT / "reports/costs/reproduce.json").read_text(encoding="utf-8"))
    took = f"took {measured['seconds'] / 60:.0f} minutes on two cores"
    assert took in README and measured["changed"] == []


def test_the_table_of_costs_is_the_committed_measurement_s():
    assert expected_costs() in README


def test_every_link_into_the_repository_leads_somewhere():
    links = re.findall(r"\]\((?!https?:)([^)#]+)", README)
    assert len(links) > 10
    assert [link for link in links if not (ROOT / link).exists()] == []


@pytest.mark.parametrize(
    ("stage", "figure", "name"),
    [
        ("close_gap", "causes_arena.png", "causes_arena.png"),
        ("close_gap", "errors_arena.png", "errors_arena.png"),
        ("hidden_effects", "accuracy.png", "exam_accuracy.png"),
        ("hidden_effects", "confusion.png", "exam_confusion.png"),
    ],
)
def test_the_pictures_are_the_committed_run_s(stage, figure, name):
    drawn = ROOT / "reports" / stage / "figures" / figure
    if not drawn.exists():
        pytest.skip(f"git keeps no figures of stages; run `dvc repro {stage}`")
    assert (ROOT / "docs" / "images" / name).read_bytes() == drawn.read_bytes()
