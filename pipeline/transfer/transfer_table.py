"""The transfer table of sim-to-real: hits and returns with physics and with what was learned."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from pipeline.paper.values import printed_transfer
from pipeline.transfer.rates import OUTCOMES
from pipeline.transfer.replay_trials import EveryTick

SETTING = ["set", "horizons_ms"]  # what tells two comparisons apart
PHYSICS = "physics"
BASELINE = {"predictor": PHYSICS, "protocol": EveryTick.protocol}  # of what others gain
THE_PAPER = "the paper's"
NUMBERS = [outcome.number for outcome in OUTCOMES]


def in_the_form_of_the_paper(table: pd.DataFrame, learned: Sequence[str]) -> pd.DataFrame:
    """Return hits and returns, physics beside what was learned, and the paper's below ours.

    Args:
        table: ``rates`` by set, horizons, predictor and protocol.
        learned: the predictors to set beside physics.

    Returns:
        One row a set and learned predictor, and one of the paper's for each set that it has.
    """
    asked = table[table["protocol"] == EveryTick.protocol]
    horizons = list(table["horizons_ms"].unique())
    rows = []
    for name, members in asked.groupby("set", sort=False):
        rows += [_own_row(members, str(name), one) for one in learned]
        if name in printed_transfer():
            rows.append(_paper_row(str(name), horizons))
    return pd.DataFrame(rows)


def _own_row(members: pd.DataFrame, name: str, learned: str) -> dict[str, Any]:
    row = {"set": name, "learned_predictor": learned, "shots": members["balls"].iloc[0]}
    for ahead, own in members.groupby("horizons_ms", sort=False):
        for kind, predictor in (("physics", PHYSICS), ("learned", learned)):
            found = own[own["predictor"] == predictor].iloc[0]
            row |= {f"{ahead} ms: {kind} {number}": found[number] for number in NUMBERS}
    return row


def _paper_row(name: str, horizons: Sequence[str]) -> dict[str, Any]:
    printed = printed_transfer()[name]
    row = {"set": name, "learned_predictor": THE_PAPER, "shots": printed.shots}
    for ahead in horizons:
        for kind, counts in printed.counts.get(ahead, {}).items():
            row |= {f"{ahead} ms: {kind} {outcome}": count for outcome, count in counts.items()}
    return row
