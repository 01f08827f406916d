"""Measured effects that docs/deviations.md quotes, from the committed runs, as generated blocks.

Errors are mean position errors at 300 ms; ``run`` is a folder of the reports, ``.`` the last run.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.io.artifacts import read_json
from pipeline.params import read_yaml

MEASURED = ["isr_ball_prediction", "spindoe", "tt3d"]
ARENA = ["stroke_pro", "stroke_uni", "receive"]


def _table(root: Path, run: str, name: str, query: str = "") -> pd.DataFrame:
    table = pd.read_csv(root / "reports" / run / name)
    return table.query(query) if query else table


def _errors(
    root: Path, run: str = ".", against: str = "measured", bounce: str = "all"
) -> pd.DataFrame:
    """Return mean position errors (mm): a row per set, a column per predictor."""
    query = "against == @against and quantity == 'position' and bounce == @bounce"
    table = pd.read_csv(root / "reports" / run / "evaluate_predictor/forecast_error.csv")
    chosen = table.query(f"{query} and horizon_ms == 300")
    return chosen.pivot(index="set", columns="predictor", values="mean")


def _gains(root: Path, run: str, predictor: str, protocol: str = "every_tick") -> pd.DataFrame:
    """Return gains in returns over physics at every tick (points), by set and horizons."""
    table = pd.read_csv(root / "reports" / run / "sim2real/difference.csv")
    query = "predictor == @predictor and outcome == 'returns' and protocol == @protocol"
    chosen = table.query(query).set_index(["set", "horizons_ms"])
    return 100 * chosen[["difference", "ci_low", "ci_high"]]


def _return_rates(root: Path, run: str, group: str) -> pd.Series:
    """Return return rates of the policies of a group in simulator C (%), by horizons."""
    table = _table(root, run, "train_policy/policies.csv", "simulator == 'imperfect_c'")
    return 100 * table[table["group"] == group].set_index("horizons_ms")["return_rate"]


def _ends(values: Any, places: int = 0) -> str:
    return f"{values.min():.{places}f} to {values.max():.{places}f}"


def _listed(values: Any) -> str:
    *first, last = (f"{value:.0f}" for value in values)
    return f"{', '.join(first)} and {last}"


def _significant(gains: pd.DataFrame) -> str:
    """Return the gains whose interval excludes zero."""
    chosen = gains[gains["ci_low"].gt(0) | gains["ci_high"].lt(0)]
    rows = [f"{row[0]:.1f} points ({row[1]:.1f} to {row[2]:.1f})" for row in chosen.to_numpy()]
    return ", ".join(rows) or "none"


def _arena_network(root: Path) -> str:
    errors = _errors(root, "real").loc[MEASURED]
    physics = errors[["physics_c", "physics_literature"]].min(axis=1)
    return (
        f"a network trained on the arena alone has errors of {_listed(errors['transformer'])} mm "
        f"on isr_ball_prediction, spindoe and tt3d; the better of two sets of physics constants "
        f"{_listed(physics)} mm (`reports/real`)"
    )


def _fine_tuning(root: Path) -> str:
    errors = _errors(root, "real").loc[MEASURED, "transformer_fine_tuned"]
    shots = _table(root, "real", "segment/splits.csv", "split == 'train' and source in @MEASURED")
    return (
        f"fine-tuned on {_ends(shots['episodes'])} measured shots per set: {_listed(errors)} mm on "
        "isr_ball_prediction, spindoe and tt3d (`reports/real`)"
    )


def _unbroken(root: Path) -> str:
    sets = read_json(root / "reports/real/segment/metrics.json")
    shares = 100 * pd.Series({name: one["unbroken_share"] for name, one in sets.items()})
    return (
        f"{shares['arena']:.0f} % of the arena's episodes are unbroken, "
        f"{_ends(shares[MEASURED])} % of the measured sets' (`reports/real/segment/metrics.json`)"
    )


def _bounces(root: Path) -> str:
    within, without = (_errors(root, bounce=name).loc["arena"] for name in ("with", "without"))
    texts = [
        f"{within[name]:.0f} mm with a bounce and {without[name]:.0f} mm without ({name})"
        for name in ("transformer", "oracle")
    ]
    return ", ".join(texts)


def _truth(root: Path) -> str:
    measured, true = (
        _errors(root, against=name)["transformer"]["arena"] for name in ("measured", "truth")
    )
    return (
        f"{measured:.1f} mm against the measured state, {true:.1f} mm against the true state "
        "(transformer)"
    )


def _constants(root: Path) -> str:
    found = _errors(root).loc["arena"]
    return (
        f"{found['physics_c']:.0f} mm with simulator C, {found['physics_literature']:.0f} mm with "
        f"the literature's constants, {found['amended_imperfect_c']:.0f} mm with simulator C "
        f"amended from training shots, {found['oracle']:.0f} mm with the hidden physics"
    )


def _epochs(root: Path) -> str:
    short, long, more = (
        _errors(root, run).loc["arena", ["transformer", "tae", "gru_tae"]]
        for run in (".", "real", "paper")
    )
    return (
        f"transformer, TAE and GRU-TAE: {_listed(short)} mm after 32 epochs (`reports`), "
        f"{_listed(long)} mm after 70 (`reports/real`), {_listed(more)} mm with the paper's number "
        f"of shots (`reports/paper`). GRU-TAE minus TAE: {_baselines(root, '.')} after 32 epochs, "
        f"{_baselines(root, 'real')} after 70"
    )


def _baselines(root: Path, run: str) -> str:
    query = (
        "set == 'arena' and quantity == 'position' and horizon_ms == 300 "
        "and predictor == 'gru_tae' and other == 'tae'"
    )
    row = _table(root, run, "evaluate_predictor/forecast_error_difference.csv", query).iloc[0]
    return f"{row['mean']:.1f} mm ({row['ci_low']:.1f} to {row['ci_high']:.1f})"


def _policy_training(root: Path) -> str:
    short, long = (_ends(_return_rates(root, run, "sim2sim")) for run in (".", "policies"))
    return (
        f"longer training in simulator C: returns from {short} % (`reports/train_policy`) to "
        f"{long} % (`reports/policies`)"
    )


def _inputs(root: Path) -> str:
    strict, intercept = (
        _ends(_return_rates(root, "policies", name), 1) for name in ("strict", "sim2sim")
    )
    return f"`strict` returns {strict} %, `intercept` {intercept} % (`reports/policies`)"


def _seeds(root: Path) -> str:
    rates = _return_rates(root, "policies", "sim2sim")["115-125"]
    return f"three seeds of one setting: {_ends(rates, 1)} % (`reports/policies`)"


def _skills(root: Path) -> str:
    shots, landings = (
        _table(root, run, "train_policy/policies.csv", "group == 'sim2sim'")
        for run in ("shots", "policies")
    )
    slopes = shots.groupby("horizons_ms")[["speed_slope", "topspin_slope"]].mean().stack()
    asked, alone = (table["landing_error_m"].mean() for table in (shots, landings))
    return (
        f"with goals for speed and topspin (`reports/shots`): slopes of {_ends(slopes, 2)}, and a "
        f"mean landing error of {asked:.2f} m instead of {alone:.2f} m"
    )


def _first_state(root: Path) -> str:
    gains = _table(root, ".", "sim2sim/difference.csv").set_index("protocol")["difference"]
    first, every = (_ends(100 * gains[name]) for name in ("first_state", "re_anchored"))
    return (
        f"the right simulator gains {first} points from the first state, {every} points from the "
        "true state at every tick (`reports/sim2sim`)"
    )


def _first_window(root: Path) -> str:
    lost = -_gains(root, ".", "physics", "first_window")["difference"]
    return (
        f"physics from the first window returns {_ends(lost)} points fewer than physics at every "
        "tick (`reports/sim2real/difference.csv`)"
    )


def _swap(root: Path) -> str:
    measured = _gains(root, "real", "transformer_fine_tuned").loc[MEASURED]
    tuned = _gains(root, "real", "transformer_fine_tuned").loc[ARENA]
    laptop, paper = (_gains(root, run, "transformer").loc[ARENA] for run in (".", "paper"))
    return (
        "gain in returns over physics at every tick, with the fine-tuned transformer on measured "
        f"sets: {_ends(measured['difference'])} points; 95 % intervals that exclude zero: "
        f"{_significant(measured)} (`reports/real/sim2real`). On the arena's shots, of "
        f"{len(laptop)} intervals each, those that exclude zero: {_significant(laptop)} "
        f"(`reports`), {_significant(paper)} (`reports/paper`), {_significant(tuned)} (fine-tuned, "
        "`reports/real`)"
    )


def _reach(root: Path) -> str:
    shots = _table(root, ".", "sim2real/replayed.csv").set_index("set").loc[ARENA]
    counts = [
        f"{inside} of {whole}" for inside, whole in shots[["in_reach", "replayed"]].to_numpy()
    ]
    return f"{', '.join(counts)} are in reach (`reports/sim2real/replayed.csv`)"


def _forest(root: Path) -> str:
    scores = _table(root, ".", "shot_quality/scores.csv", "outcome == 'wins'")
    areas = scores.set_index("method")["roc_auc"]
    return (
        f"ROC-AUC {areas['forest']:.2f}, of a logistic regression {areas['logistic']:.2f} "
        "(`reports/shot_quality/scores.csv`)"
    )


def _forest_label(root: Path) -> str:
    query = "protocol == 'every_tick' and predictor in ('physics', 'transformer')"
    rows = _table(root, ".", "shot_quality/win_probability.csv", query)
    by_predictor = rows.pivot_table("point", ["set", "horizons_ms"], "predictor")
    apart = (by_predictor["transformer"] - by_predictor["physics"]).abs().max()
    return (
        f"by the outcome of the point, medians are {_ends(rows['point'], 2)}, and physics and the "
        f"transformer differ by at most {apart:.2f} (`reports/shot_quality/win_probability.csv`)"
    )


def _forest_settings(root: Path) -> str:
    forest = read_yaml(root / "params.yaml")["shot_quality"]["forest"]
    return f"{forest['trees']} trees with at least {forest['min_samples_leaf']} shots per leaf"


def _precision(root: Path) -> str:
    rows = _table(root, "costs", "precision.csv").set_index("measure")
    columns = ["difference", "ci_low", "ci_high"]
    position = "{:.2f} ({:.2f} to {:.2f}) mm from 100 to 300 ms".format(
        *rows.loc["position error, 100 to 300 ms (mm)", columns]
    )
    spin = "{:.2f} ({:.2f} to {:.2f}) rad/s at 300 ms".format(
        *rows.loc["spin error at 300 ms (rad/s)", columns]
    )
    return f"16 bits minus 32: {position} and {spin} (`reports/costs/precision.csv`)"


BLOCKS: dict[str, Callable[[Path], str]] = {
    "deviations.arena_network": _arena_network,
    "deviations.fine_tuning": _fine_tuning,
    "deviations.unbroken": _unbroken,
    "deviations.bounces": _bounces,
    "deviations.truth": _truth,
    "deviations.constants": _constants,
    "deviations.epochs": _epochs,
    "deviations.policy_training": _policy_training,
    "deviations.inputs": _inputs,
    "deviations.seeds": _seeds,
    "deviations.skills": _skills,
    "deviations.first_state": _first_state,
    "deviations.first_window": _first_window,
    "deviations.swap": _swap,
    "deviations.reach": _reach,
    "deviations.forest": _forest,
    "deviations.forest_label": _forest_label,
    "deviations.forest_settings": _forest_settings,
    "deviations.precision": _precision,
}
