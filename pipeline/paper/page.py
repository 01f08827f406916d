"""docs/paper.md: every number of the paper with ours, in Markdown."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from rallygap.pipeline.io.markdown import markdown_table
from rallygap.pipeline.paper.assessments import DIFFERS, MEANINGS
from rallygap.pipeline.paper.comparison import (
    NOTHING,
    Exhibit,
    Finding,
    Group,
    Value,
    compare,
    exhibits,
    groups,
)
from rallygap.pipeline.paper.forecast_errors import LEARNED
from rallygap.pipeline.paper.run_reports import (
    Reports,
    is_kept_run,
    kept_reports,
    laptop_reports,
    paper_reports,
)
from rallygap.pipeline.paper.settings import NETWORK, TRAINING
from rallygap.pipeline.paper.sources import number

PREDICTORS = "evaluate_predictor/predictors.csv"
LAPTOP, PAPER, SHOTS = "laptop", "paper", "shots"  # runs
TITLES = {
    LAPTOP: "laptop",
    PAPER: "paper's number of shots",
    SHOTS: "goals of speed and topspin",
}
OF_POLICIES = {"train_policy", "sim2sim", "sim2real", "shot_quality"}  # stages

PREAMBLE = """# Comparison with the paper

*Bridging the sim2real gap in the table tennis robot with a transformer-based ball states predictor*
(Bi, Conti, Yang, Sigrist, Dürr, Takahashi; Sony AI): each figure, table and printed number, our
number, the stage that produces it, and an assessment. Generated from `pipeline/paper` and the
reports (`make docs`); `reports/index.html` shows the same with drawings.

- *laptop* is the last run (`reports/`). *paper* is the run with the paper's number of shots
  (`reports/paper/`; its `run.json` has the command and the parameters).
{shots}- Intervals are 95 % intervals. A dash means that there is no number.
- Shots, arm and policy differ from the paper's. What can be compared are differences between
  predictors and their signs ([deviations](deviations.md)).
"""

OTHER_GOALS = """\
- *shots* (`reports/shots/`) has predictors with the settings of *laptop*, and policies that are
  asked for speed and topspin, {repeats} trainings of each. It is shown for policies only.
"""

NOT_RUN = """- `reports/paper/` does not exist: its columns have settings only. To fill it:
  `dvc exp run --name paper $(rallygap profile paper)`, `rallygap keep paper`.
"""

SMALLER = """- The run *paper* has the paper's number of shots, but its transformer, of {parameters}
  parameters, differs from the paper's: {settings}.
  [Results](results.md#the-papers-network) has the errors of a transformer of the paper's size. The
  profile `paper`, with the paper's network, training and policies, has not been run:
  `dvc exp run --name paper $(rallygap profile paper)`, `rallygap keep paper`.
"""
COMPARED = (f"{NETWORK}.width", f"{TRAINING}.batch", f"{TRAINING}.epochs")  # settings


def paper_page(root: Path) -> str:
    """Return the comparison of a repository's reports with the paper as Markdown.

    Raises:
        InputError: a report is broken.
    """
    runs = compared_runs(root)
    found = {name: compare(run) for name, run in runs.items()}
    preamble = PREAMBLE.format(shots=_other_goals(runs)) + _size(runs[PAPER], found[PAPER])
    parts = [preamble, _meanings(), _exhibits(runs)]
    parts += [_group(group, found) for group in groups()]
    return "\n".join(parts).rstrip()


def claims_table(root: Path) -> str:
    """Return the paper's figures and tables with the assessments of all runs as a Markdown table.

    Raises:
        InputError: a report is broken.
    """
    runs = compared_runs(root)
    rows = [[one.name, one.what, *_assessments(one, runs)] for one in exhibits() if one.claims]
    return markdown_table(["in the paper", "what", *(TITLES[name] for name in runs)], rows)


def compared_runs(root: Path) -> dict[str, Reports]:
    """Return the runs that are compared; that of other policies only where it was kept."""
    runs = {LAPTOP: laptop_reports(root), PAPER: paper_reports(root)}
    folder = root / "reports" / SHOTS
    return runs | ({SHOTS: kept_reports(folder)} if is_kept_run(folder) else {})


def _is_shown(name: str, stages: Iterable[str]) -> bool:
    """Return whether a run is shown for numbers of some stages."""
    return name != SHOTS or not OF_POLICIES.isdisjoint(stages)


def _assessments(exhibit: Exhibit, runs: Mapping[str, Reports]) -> list[str]:
    return [
        exhibit.assessment(run) if _is_shown(name, [exhibit.stage]) else NOTHING
        for name, run in runs.items()
    ]


def _other_goals(runs: Mapping[str, Reports]) -> str:
    if SHOTS not in runs:
        return ""
    return OTHER_GOALS.format(repeats=runs[SHOTS].param("train_policy.groups.sim2sim.repeats"))


def _size(paper: Reports, found: dict[str, Finding]) -> str:
    """Return how the run `paper` differs from the profile `paper`."""
    if not paper.folder.is_dir():
        return NOT_RUN
    values = {value.id: value for group in groups() for value in group.values}
    settings = [
        f"{values[name].what} {found[name].shown} instead of {values[name].printed_text}"
        for name in (f"setting.{path}" for path in COMPARED)
        if found[name].assessment == DIFFERS
    ]
    parameters = paper.number(PREDICTORS, "parameters", predictor=LEARNED)
    shown = NOTHING if parameters is None else number(parameters)
    return SMALLER.format(parameters=shown, settings=", ".join(settings)) if settings else ""


def _meanings() -> str:
    rows = [[f"*{word}*", meaning] for word, meaning in MEANINGS.items()]
    return _section("Assessments", "", ["assessment", "meaning"], rows)


def _exhibits(runs: Mapping[str, Reports]) -> str:
    rows = [
        [one.name, one.what, f"`{one.stage}`", one.ours, *_assessments(one, runs)]
        for one in exhibits()
    ]
    names = ["in the paper", "what", "stage", "ours", *(f"assessment: {name}" for name in runs)]
    about = (
        "Paths are relative to `reports/`. The assessment of a figure follows from all its rows."
    )
    return _section("Figures and tables", about, names, rows)


def _group(group: Group, found: Mapping[str, Mapping[str, Finding]]) -> str:
    stages = [value.stage for value in group.values]
    runs = {name: one for name, one in found.items() if _is_shown(name, stages)}
    rows = [_row(value, [one[value.id] for one in runs.values()]) for value in group.values]
    ours = [head for name in runs for head in (f"run {name}", "assessment")]
    names = ["what", "stage: source", "printed in the paper", *ours]
    return _section(group.title, group.about, names, rows)


def _row(value: Value, found: list[Finding]) -> list[str]:
    stage = "" if value.stage == NOTHING else f"`{value.stage}`: "
    ours = [text for one in found for text in (one.shown, one.assessment)]
    return [value.what, f"{stage}{value.ours.place}", value.printed_text, *ours]


def _section(title: str, about: str, names: list[str], rows: list[list[str]]) -> str:
    return "\n\n".join(filter(None, [f"## {title}", about, markdown_table(names, rows)])) + "\n"
