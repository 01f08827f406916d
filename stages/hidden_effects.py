"""The blind exam: what the methods find in recordings in which an effect is hidden."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from models.exam.design.questions import spread
from models.exam.record import Sheet
from models.exam.scoring.rates import rates
from pipeline.exam.figures.methods import accuracy_figure, methods_figure
from pipeline.exam.figures.single_method import confusion_figure, coverage_figure
from pipeline.exam.records import SHEETS, Sat, read_sheets, seats, sit_all
from pipeline.exam.tables import (
    answer_table,
    differing,
    effect_table,
    group_table,
    methods_of,
    not_posed_table,
    rate_table,
    shortfall_table,
)
from pipeline.io.artifacts import write_json
from pipeline.runtime.console import warn
from pipeline.runtime.stage_run import StageRun, run_stage

SOLVED = (
    "Solved: a cause that the data tell from all others has the right name, any other one is in "
    "the class of a cause, and nothing else is named; on clean sets there is no gap, and a "
    "withheld effect is called unknown."
)


def hidden_effects(run: StageRun) -> None:
    """Sit a few questions anew, and report what all the sheets of the exam say."""
    path = run.root / SHEETS
    kept = read_sheets(path)
    run.log_input("sheets of the exam", path, len(kept))
    sat = _sat_anew(run)
    other = differing([one.sheet for one in sat], kept)
    if other:
        warn(f"{len(other)} of {len(sat)} answers are not those of {SHEETS}; run `make exam`")
    ours, *peers = methods_of(kept)
    results = {
        "questions": len(kept),
        "not_posed": sum(one.not_posed is not None for one in kept),
        **rates(kept, ours),
        "compared": {name: rates(kept, name) for name in peers},
    }
    write_json(run.report("exam.json"), results)
    known = {name: value for name, value in results.items() if isinstance(value, int | float)}
    run.write_metrics({"exam": known, "sat_anew": {"trials": len(sat), "differing": len(other)}})
    _add_figures(run, kept, [ours, *peers])
    _add_tables(run, kept, ours)
    _add_answers(run, sat, other)


def _sat_anew(run: StageRun) -> list[Sat]:
    few = spread(seats(run.params), run.params.hidden_effects.trials)
    sat = sit_all(few, run.scratch("sheets"))
    for method in sorted({name for one in sat for name in one.seconds}):
        taken = [one.seconds[method] for one in sat if method in one.seconds]
        run.timings[f"{method}_cpu_s_median"] = float(np.median(taken))
    return sat


def _add_figures(run: StageRun, sheets: Sequence[Sheet], methods: Sequence[str]) -> None:
    ours = methods[0]
    run.add_figure(
        confusion_figure(sheets, ours),
        "confusion",
        title="What was hidden and what was named",
        caption="Each effect at three times its detectable size, in 100 shots, and sets without "
        "any gap. Where data cannot tell effects apart, the verdict is a class, here shown by its "
        "first name.",
    )
    run.add_figure(
        accuracy_figure(sheets, methods),
        "accuracy",
        title="Finding the right name",
        caption=f"{SOLVED} Bands: 95 % intervals. What varies is the size of what is hidden, "
        "the number of shots or the noise; sizes are multiples of what each set can show.",
    )
    run.add_figure(
        coverage_figure(sheets, ours),
        "coverage",
        title="Do 95 % intervals hold the truth?",
        caption="Of rightly named numbers at three times the detectable size or more, in how many "
        "the interval holds the truth; whiskers: 95 % intervals of that share.",
    )
    run.add_figure(
        methods_figure(sheets, methods),
        "methods",
        title="Methods side by side",
        caption="All asked the same of the same recordings; whiskers: 95 % intervals. A dash where "
        "a method has nothing that could be counted.",
    )


def _add_tables(run: StageRun, sheets: Sequence[Sheet], ours: str) -> None:
    tables: dict[str, tuple[Any, str, str]] = {
        "rates": (rate_table(sheets), "The exam: rates", "Each with its counts."),
        "effects": (
            effect_table(sheets, ours),
            "The exam: effect by effect",
            "At three times the detectable size, in 100 shots. own_class: trials in which the data "
            "tell it from all others; not_posed: in which they do not show it.",
        ),
        "groups": (
            group_table(sheets, ours),
            "The exam: groups of questions",
            f"Share of solved questions by method. {SOLVED} removable_closed: the share of the "
            f"removable gap that {ours} closed.",
        ),
        "shortfalls": (
            shortfall_table(sheets, ours),
            "The exam: every shortfall",
            f"Questions that {ours} did not solve, by trial.",
        ),
        "not_posed": (
            not_posed_table(sheets),
            "The exam: questions that could not be posed",
            "What was to be hidden, and why it was not.",
        ),
    }
    for name, (table, title, caption) in tables.items():
        run.add_table(table, name, title=title, caption=caption)


def _add_answers(run: StageRun, sat: Sequence[Sat], other: Sequence[str]) -> None:
    sheets = [one.sheet for one in sat]
    table = answer_table(sheets, methods_of(sheets))
    run.add_table(
        table.assign(as_kept=~table["trial"].isin(other)),
        "sat_anew",
        title="The exam: questions sat anew",
        caption=f"{len(sheets)} questions spread over the exam, {len(table)} answers. as_kept: "
        "whether they are those that the rates rest on.",
    )


if __name__ == "__main__":
    run_stage(hidden_effects)
