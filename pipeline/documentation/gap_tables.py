"""Tables of the gap workflow: the arena, the exam, measured sets."""

from pathlib import Path
from typing import Any

import pandas as pd

from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS
from rallygap.pipeline.documentation.cells import (
    HORIZON_HEADS,
    NONE,
    before_after,
    number,
    read_report,
    with_interval,
)
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.io.markdown import markdown_table
from rallygap.pipeline.web.labels import SIMULATORS

RACKET = "racket_bounce"  # which the gap workflow's shots do not touch
CAMERA = "camera_distortion"  # stands for a field, which has no single true value
SETS = ("spindoe", "tt3d", "isr_ball_prediction")
RATES = {  # what the exam counts: the number of right answers, and of questions
    "clean sets with a false alarm": ("false_alarms", "clean_sets"),
    "one distinguishable cause at 3 detection limits: named": (
        "distinguishable_right",
        "distinguishable",
    ),
    "one indistinguishable cause at 3 detection limits: its class named": (
        "indistinguishable_right",
        "indistinguishable",
    ),
    "two causes: both named": ("pairs_right", "pairs"),
    "withheld effect: answer unknown": ("withheld_right", "withheld"),
    "95 % intervals of correctly named causes that contain the true value": (
        "intervals_right",
        "intervals",
    ),
}


ROBUSTNESS_RATES = {  # the same of the robustness groups
    "clean sets with a physical cause named": ("false_leading", "clean_sets_new"),
    "constant causes at 3 detection limits or more: leading cause named": (
        "leading_right",
        "constant_new",
    ),
    "constant causes at 3 detection limits or more: all named, and no other": (
        "exact_right",
        "constant_new",
    ),
    "95 % intervals of correctly named causes that contain the true value": (
        "intervals_new_right",
        "intervals_new",
    ),
    "varying cause: no other cause named, not `no_gap`": ("varying_new_right", "varying_new"),
}


def arena_causes(root: Path, run: str = "") -> str:
    """Parameters that were wrong or missing in simulator C, from ``retrain_policy`` of a run."""
    table = read_report(root, f"{run}retrain_policy/numbers.csv", "source == 'arena'")
    table = table[table["effect"] != RACKET]
    table = table[table["amended"].fillna(0) != table["truth"].fillna(0)]
    table = table[table["low"].notna() | table["truth"].notna()]  # neither named nor hidden
    rows = []
    for row in table.itertuples():
        amended = row.amended if pd.notna(row.low) else float("nan")
        named = with_interval(amended, row.low, row.high, ".4g")
        parameter = f"`{row.effect}.{row.parameter}`"
        truth = "camera field" if row.effect == CAMERA else number(row.truth)
        rows.append([parameter, number(row.original), named, truth])
    return markdown_table(["parameter", "simulator C", "named (95 % interval)", "arena"], rows)


def arena_verdict(root: Path) -> str:
    """The verdict on the arena, and causes that its shots cannot tell apart, in a sentence."""
    case = read_report(root, "close_gap/verdicts.csv", "source == 'arena'").iloc[0]
    query = "source == 'arena' and simulator == @case.simulator and split == @case.split"
    causes = read_report(root, "close_gap/causes.csv").query(f"{query} and role != 'minor'")
    classes = [one.split(", ") for one in causes["possible"] if ", " in one]
    others = (f"`{first}` may be `{'` or `'.join(rest)}`" for first, *rest in classes)
    return f"The verdict is `{case['verdict']}`" + (f" ({'; '.join(others)})" if classes else "")


def exam_rates(root: Path) -> str:
    """Counts of the exam for every method, from ``hidden_effects``; a dash without records."""
    methods = _exam_results(root)
    shares = (one["removable_closed"] for one in methods.values())
    closed = [NONE if share is None else f"{100 * share:.0f}" for share in shares]
    rows = [*_exam_rows(methods, RATES), ["removable gap closed (%)", *closed]]
    return markdown_table(["", *methods], rows)


def robustness_rates(root: Path) -> str:
    """Counts of the exam's robustness groups; a dash where they have no records."""
    methods = _exam_results(root)
    return markdown_table(["", *methods], _exam_rows(methods, ROBUSTNESS_RATES))


def _exam_results(root: Path) -> dict[str, dict[str, Any]]:
    results = read_json(root / "reports/hidden_effects/exam.json")
    return {"rallygap": results, **results["compared"]}


def _exam_rows(
    methods: dict[str, dict[str, Any]], rates: dict[str, tuple[str, str]]
) -> list[list[str]]:
    return [
        [
            name,
            *(
                f"{one[right]} of {one[asked]}" if one.get(asked) else NONE
                for one in methods.values()
            ),
        ]
        for name, (right, asked) in rates.items()
    ]


def real_summary(root: Path) -> str:
    """Errors on held-out shots of the measured sets, a row a set and base simulator."""
    errors, verdicts, causes = (_real(root, name) for name in ("errors", "verdicts", "stability"))
    is_gravity = causes["cause"].astype("string").str.startswith("gravity", na=False)
    gravities = causes[is_gravity]
    rows = []
    for (source, base), some in verdicts.groupby(["source", "simulator"], sort=False):
        chosen = "source == @source and simulator == @base"
        means = errors.query(chosen).groupby("horizon_ms").mean(numeric_only=True)
        means = means.reindex(SHOWN_HORIZONS_MS)
        gravity = int(gravities.query(chosen)["found"].sum())
        falls, named = changes(some)[0], (some["verdict"] == "named").sum()
        cells = [before_after(means.loc[horizon]) for horizon in SHOWN_HORIZONS_MS]
        counts = [f"{count} of {len(some)}" for count in (falls, named, gravity)]
        rows.append([source, SIMULATORS[base], *cells, *counts])
    head = ["set", "nominal simulator", *HORIZON_HEADS]
    return markdown_table([*head, "error falls", "verdict `named`", "gravity leading"], rows)


def changes(verdicts: Any) -> tuple[int, int]:
    """Return in how many verdicts the held-out error falls, and rises, with its whole interval."""
    falls, rises = verdicts["reduction_low_mm"] > 0, verdicts["reduction_high_mm"] < 0
    return int(falls.sum()), int(rises.sum())


def real_errors(root: Path) -> str:
    """Errors on held-out shots of the measured sets, a row a verdict."""
    keys = ["source", "simulator", "split", "horizon_ms"]
    errors = _real(root, "errors").set_index(keys)
    rows = []
    for _, row in _real(root, "verdicts").iterrows():
        at = [(*row[keys[:3]], horizon) for horizon in SHOWN_HORIZONS_MS]
        cells = [before_after(errors.loc[one]) if one in errors.index else NONE for one in at]
        fall = f"{row['reduction_low_mm']:z.0f} to {row['reduction_high_mm']:z.0f}"
        case = [row["source"], SIMULATORS[row["simulator"]], row["split"], row["verdict"]]
        rows.append([*case, *cells, fall, before_after(row, "landing_")])
    head = ["set", "nominal simulator", "split", "verdict", *HORIZON_HEADS]
    return markdown_table([*head, "error falls by (mm)", "landing"], rows)


def real_causes(root: Path) -> str:
    """Causes on the measured sets that at least two of three splits name."""
    rows = []
    for row in _real(root, "stability").query("found >= 2").itertuples():
        unit = "" if row.unit == "1" else f" {row.unit}"
        values = f"{row.lowest:.3g} to {row.highest:.3g}{unit}"
        splits = f"{row.found:.0f} of {row.splits}"
        rows.append([row.source, SIMULATORS[row.simulator], f"`{row.cause}`", splits, values])
    return markdown_table(["set", "nominal simulator", "cause", "splits", "estimates"], rows)


def real_stability(root: Path) -> str:
    """Verdicts on the measured sets, and how many of their leading causes all splits have."""
    verdicts, causes = _real(root, "verdicts"), _real(root, "causes")
    splits = verdicts["split"].nunique()
    leading_causes = _leading_causes(causes[causes["role"] == "leading"])
    rows = []
    for source, some in verdicts.groupby("source", sort=False):
        leading = leading_causes[leading_causes["source"] == source]
        everywhere = leading[leading["found"] == splits]
        better, worse = changes(some)
        counts = [
            ", ".join(f"{count} {name}" for name, count in some["verdict"].value_counts().items()),
            f"{better}, {worse}",
            f"{len(everywhere)} of {len(leading)}",
            f"{everywhere['agree'].sum()} of {len(everywhere)}",
        ]
        rows.append([source, *counts])
    head = ["set", "verdicts", "predictions better, worse", "leading causes that all splits have"]
    return markdown_table([*head, "of these, with a value in all intervals"], rows)


def _leading_causes(leading: Any) -> Any:
    """Return the causes of each simulator: in how many splits they lead, and whether these agree.

    Splits agree if one value is in all their intervals.
    """
    groups = leading.groupby(["source", "simulator", "cause"])
    ends = groups.agg(found=("split", "size"), low=("low", "max"), high=("high", "min"))
    return ends.assign(agree=ends["low"] <= ends["high"]).reset_index()


def _real(root: Path, name: str) -> Any:
    table = read_report(root, f"real/close_gap/{name}.csv")
    return table[table["source"].isin(SETS)]
