"""Hits and returns with physics and with learned predictors, in the form of the paper's table."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from rallygap.pipeline.paper.values import printed_transfer
from rallygap.pipeline.transfer.rates import OUTCOMES
from rallygap.pipeline.transfer.replay_trials import EVERY_STEP, ONCE

SETTING = ["set", "horizons_ms"]  # of a comparison
PHYSICS = "physics"
BASELINE = {"predictor": PHYSICS, "protocol": EVERY_STEP}  # of gains
PAPER_ROW = "the paper's"
PROTOCOLS = {ONCE: "first window", EVERY_STEP: "every control step"}
COUNTS = [outcome.counts for outcome in OUTCOMES]


def paper_form_table(table: pd.DataFrame, learned: Sequence[str]) -> pd.DataFrame:
    """Return numbers of hits and returns with physics and with learned predictors.

    Args:
        table: ``rates`` by set, horizons, predictor and protocol.
        learned: predictors to compare with physics.

    Returns:
        One row per set and learned predictor, and the paper's row for each set that it has.
    """
    every_step = table[table["protocol"] == EVERY_STEP]
    horizons = list(table["horizons_ms"].unique())
    rows = []
    for name, members in every_step.groupby("set", sort=False):
        rows += [_row(members, str(name), one) for one in learned]
        if name in printed_transfer():
            rows.append(_paper_row(str(name), horizons))
    return pd.DataFrame(rows)


def _row(members: pd.DataFrame, name: str, learned: str) -> dict[str, Any]:
    row = {"set": name, "learned_predictor": learned, "shots": members["balls"].iloc[0]}
    for horizons, rows in members.groupby("horizons_ms", sort=False):
        for kind, predictor in (("physics", PHYSICS), ("learned", learned)):
            counts = rows[rows["predictor"] == predictor].iloc[0]
            row |= {f"{horizons} ms: {kind} {count}": counts[count] for count in COUNTS}
    return row


def _paper_row(name: str, horizons: Sequence[str]) -> dict[str, Any]:
    printed = printed_transfer()[name]
    row = {"set": name, "learned_predictor": PAPER_ROW, "shots": printed.shots}
    for label in horizons:
        for kind, counts in printed.counts.get(label, {}).items():
            row |= {f"{label} ms: {kind} {outcome}": count for outcome, count in counts.items()}
    return row
