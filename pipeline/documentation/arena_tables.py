"""Tables of fresh arenas, from ``make arenas``."""

from collections.abc import Callable
from math import nan
from pathlib import Path

import pandas as pd

from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS
from rallygap.pipeline.documentation.cells import (
    HORIZON_HEADS,
    NONE,
    read_report,
    with_interval,
)
from rallygap.pipeline.experiments.arenas.scores import (
    PREDICTORS,
    Share,
    coverage,
    found_by_size,
    gap_closed,
    made_up,
    ratios,
    scored,
)
from rallygap.pipeline.io.markdown import markdown_table
from rallygap.pipeline.paper.assessments import rate

# Hidden differences that shots hardly tell from a parameter: what is not named of them shifts it.
SIMILAR = {
    "table_bounce.restitution": "speed_dependent_restitution.c",
    "wind.x": "table_tilt.x",
    "wind.y": "table_tilt.y",
}


def arena_causes_found(root: Path) -> str:
    """How many hidden differences are named, by their size, and what else is named."""
    causes = read_report(root, "arenas/causes.csv")
    rows = [[f"hidden, {name}", *_shown(share)] for name, share in found_by_size(causes)]
    rows.append(["named, but not hidden", *_shown(made_up(causes))])
    rows.append(["95 % intervals that contain the true value", *_shown(coverage(causes))])
    return markdown_table(["difference", "named", "share (%)"], rows)


def by_arena(root: Path) -> str:
    """What is named in an arena, over the fresh arenas and in the arena of the development."""
    fresh = [one for _, one in read_report(root, "arenas/causes.csv").groupby("seed")]
    known = read_report(root, "retrain_policy/numbers.csv").assign(detectable=nan)  # not there
    rows = []
    for what, measure in OF_AN_ARENA.items():
        spread = _spread(pd.Series([measure(one) for one in fresh]), ".0f")
        rows.append([what, spread, f"{measure(known):.0f}"])
    return markdown_table(["in an arena", "fresh arenas", "arena of the development"], rows)


def _found(causes: pd.DataFrame) -> Share:
    """Return how many of the hidden differences of any size are named."""
    shares = [share for _, share in found_by_size(causes)]
    return Share(sum(one.count for one in shares), sum(one.of for one in shares))


def _percent(share: Share) -> float:
    return 100 * share.count / share.of


OF_AN_ARENA: dict[str, Callable[[pd.DataFrame], float]] = {
    "hidden differences that are named (%)": lambda causes: _percent(_found(causes)),
    "named causes that are not hidden": lambda causes: made_up(causes).count,
    "95 % intervals that contain the true value (%)": lambda causes: _percent(coverage(causes)),
}


def arena_coverage_share(root: Path) -> str:
    """How many intervals contain the true value, in a part of a sentence."""
    found = coverage(read_report(root, "arenas/causes.csv"))
    share = f" ({_percent(found):.0f} %)" if found.of else ""
    return f"{found.count} of {found.of}{share}"


def arena_coverage(root: Path) -> str:
    """How many intervals have the true value, by whether a similar hidden difference is named."""
    found = scored(read_report(root, "arenas/causes.csv"))
    identities = found["effect"] + "." + found["parameter"]
    rows = []
    for identity, similar in SIMILAR.items():
        covered = found[(identities == identity) & found["named"]].set_index("seed")["covered"]
        also = found[(identities == similar) & found["hidden"]].set_index("seed")["named"]
        pairs = pd.concat([covered, also], axis=1).dropna()
        cells = [_shown(_covered(pairs[pairs["named"] == named])) for named in (True, False)]
        shown = (": ".join(cell) + (" %" if cell[1] != NONE else "") for cell in cells)
        rows.append([identity, similar, *shown])
    return markdown_table(["interval of", "hidden as well", "named", "not named"], rows)


def arena_errors(root: Path) -> str:
    """Errors divided by the oracle's over all arenas: medians and ranges."""
    errors = read_report(root, "arenas/errors.csv")
    rows = []
    for name, label in PREDICTORS.items():
        found = (ratios(errors, name, horizon) for horizon in SHOWN_HORIZONS_MS)
        rows.append([label, *(_spread(one, ".2f") for one in found)])
    closed = (100 * gap_closed(errors, horizon) for horizon in SHOWN_HORIZONS_MS)
    rows.append(
        ["removable gap to the oracle closed (%)", *(_spread(one, ".0f") for one in closed)]
    )
    return markdown_table(["error / oracle's, or share", *HORIZON_HEADS], rows)


def _covered(pairs: pd.DataFrame) -> Share:
    return Share(int(pairs["covered"].sum()), len(pairs))


def _shown(share: Share) -> list[str]:
    counted = f"{share.count} of {share.of}"
    if not share.of:
        return [counted, NONE]
    found = rate(share.count, share.of).times(100)
    return [counted, with_interval(found.value, found.low, found.high)]


def _spread(values: "pd.Series[float]", form: str) -> str:
    """Return the median of values, and the least and the largest."""
    low, middle, high = (values.quantile(q) for q in (0.0, 0.5, 1.0))
    return f"{middle:{form}} ({low:{form}} to {high:{form}})"
