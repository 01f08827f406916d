"""How far to trust a verdict: the known answers on measured sets, a section of docs/real_gap.md."""

from pathlib import Path
from typing import Any

from rallygap.pipeline.documentation.cells import NONE, read_report
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.io.markdown import markdown_table
from rallygap.pipeline.known_answers.design import SIZES
from rallygap.pipeline.known_answers.run import REPORT, SCORES, TABLE
from rallygap.pipeline.paper.assessments import rate

RATES = {  # what is counted: the number, and of how many
    "planted error is the leading cause": ("leading", "questions"),
    "by its own name": ("by_name", "questions"),
    "leading, and no other new cause": ("exact", "questions"),
    "95 % intervals that contain the reference value": ("covered", "intervals"),
    "distorted recordings without a new leading cause": ("distorted_clean", "distorted"),
    "unplanted recordings without a leading cause": ("unplanted_clean", "unplanted"),
}

SECTION = """## How far to trust a verdict

On measured sets nobody knows the true causes. So known errors are planted, in the simulator or in
the recordings, and verdicts must find them. {folds}-fold cross-validation over recordings:
the base simulator of a fold is `{nominal}`, amended by the verdict on the other folds, and the fold
is diagnosed with it. The true value of a parameter is not known either: the reference value is the
fold's own estimate without the planted error. Brackets: 95 % intervals (Wilson).

{rates}

*New cause*: the verdict without the planted error does not have it, or has it with another value;
camera distortion is left out.
A new cause that these shots cannot separate from the planted error counts as the planted error.
How often the planted error is the leading cause, by its size in minimum detectable effects of the
fold:

{errors}

[known_answers.csv](../reports/real/known_answers.csv) has every question: what was planted, the
causes with their intervals, and the prediction errors."""


def known_answers(root: Path) -> str:
    """Return the section; empty where the known answers have not been asked."""
    if not (root / REPORT / SCORES).is_file():
        return ""
    scores = read_json(root / REPORT / SCORES)
    first = next(iter(scores.values()))
    return SECTION.format(
        folds=first["folds"],
        nominal=first["nominal"],
        rates=_rates_table(scores),
        errors=_errors_table(root),
    )


def _rates_table(scores: Any) -> str:
    rows = [
        [name, *(_share(one[right], one[asked]) for one in scores.values())]
        for name, (right, asked) in RATES.items()
    ]
    false = [str(one["false_causes"]) for one in scores.values()]
    return markdown_table(["", *scores], [*rows, ["false leading causes", *false]])


def _errors_table(root: Path) -> str:
    table = read_report(root, f"{REPORT.name}/{TABLE}", "leading.notna()")
    rows = []
    for (place, planted), some in table.groupby(["place", "planted"], sort=False):
        cells = [_count(some.loc[some["size"] == size, "leading"].astype(bool)) for size in SIZES]
        rows.append([f"`{planted}`", place, *cells])
    return markdown_table(["planted", "in", *SIZES], rows)


def _count(found: Any) -> str:
    return f"{found.sum()} of {len(found)}" if len(found) else NONE


def _share(count: int, of: int) -> str:
    if not of:
        return NONE
    share = rate(count, of)
    return f"{count} of {of} ({100 * share.low:.0f} to {100 * share.high:.0f} %)"
