"""docs/paper.md: every number of the paper with ours, in Markdown."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from rallygap.pipeline.io.markdown import markdown_table
from rallygap.pipeline.paper.assessments import MEANINGS, Finding
from rallygap.pipeline.paper.comparison import Group, compare, exhibits, groups
from rallygap.pipeline.paper.run_reports import Reports, kept_reports, laptop_reports
from rallygap.pipeline.paper.values import NOTHING

LAPTOP, PAPER, SHOTS = "laptop", "paper", "shots"  # runs
POLICY_STAGES = {"train_policy", "sim2sim", "sim2real", "shot_quality"}  # stages
PREAMBLE = """# Comparison with the paper

*Bridging the sim2real gap in the table tennis robot with a transformer-based ball states predictor*
(Bi, Conti, Yang, Sigrist, Dürr, Takahashi; Sony AI): each figure, table and printed number, our
number, the stage that produces it, and an assessment. The stage `report_experiments` writes this
page; `reports/index.html` shows the same of the last run, with drawings.

- *laptop* is the run in `reports/`. *paper* is the run with the paper's number of shots
  (`reports/paper/`; `params.json` has its parameters).
- *shots* (`reports/shots/`) has predictors with the settings of *laptop*, and policies that are
  asked for speed and topspin, 3 trainings of each. It is shown for policies only.
- Intervals are 95 % intervals. A dash means that there is no number.
- Shots, arm and policy differ from the paper's. What can be compared are differences between
  predictors and their signs ([deviations](deviations.md)).
- The run *paper* has the paper's number of shots, but its transformer, of 880,090
  parameters, differs from the paper's: width of the layers 128 instead of 512, batch size 64
  instead of 128, epochs 16 instead of 80.
  [Results](results.md#the-papers-network) has the errors of a transformer of the paper's size. The
  profile `paper_network`, with the paper's network, training and policies, has not been run as a
  whole.
"""


def paper_page(root: Path) -> str:
    """Return the comparison of a repository's reports with the paper as Markdown.

    Raises:
        InputError: a report is broken, or a kept run is missing.
    """
    runs = compared_runs(root)
    findings = {name: compare(run) for name, run in runs.items()}
    meanings = [[f"*{word}*", meaning] for word, meaning in MEANINGS.items()]
    parts = [PREAMBLE, _section("Assessments", "", ["assessment", "meaning"], meanings)]
    parts += [_exhibits(runs), *(_group(group, findings) for group in groups())]
    return "\n".join(parts).rstrip() + "\n"


def compared_runs(root: Path) -> dict[str, Reports]:
    """Return the runs that are compared with the paper."""
    kept = {name: kept_reports(root / "reports" / name) for name in (PAPER, SHOTS)}
    return {LAPTOP: laptop_reports(root), **kept}


def _is_shown(name: str, stages: Iterable[str]) -> bool:
    """Return whether a run is shown for numbers of some stages."""
    return name != SHOTS or not POLICY_STAGES.isdisjoint(stages)


def _exhibits(runs: Mapping[str, Reports]) -> str:
    rows = []
    for exhibit in exhibits():
        words = [
            exhibit.assessment(run) if _is_shown(name, [exhibit.stage]) else NOTHING
            for name, run in runs.items()
        ]
        rows.append([exhibit.name, exhibit.what, f"`{exhibit.stage}`", exhibit.ours, *words])
    names = ["in the paper", "what", "stage", "ours", *(f"assessment: {name}" for name in runs)]
    about = (
        "Paths are relative to `reports/`. The assessment of a figure follows from all its rows."
    )
    return _section("Figures and tables", about, names, rows)


def _group(group: Group, all_findings: Mapping[str, Mapping[str, Finding]]) -> str:
    stages = [value.stage for value in group.values]
    runs = {name: findings for name, findings in all_findings.items() if _is_shown(name, stages)}
    rows = []
    for value in group.values:
        stage = f"`{value.stage}`: " if value.stage else ""
        findings = [run[value.id] for run in runs.values()]
        ours = [text for finding in findings for text in (finding.shown, finding.assessment)]
        rows.append([value.what, f"{stage}{value.ours}", value.printed_text, *ours])
    heads = [head for name in runs for head in (f"run {name}", "assessment")]
    names = ["what", "stage: source", "printed in the paper", *heads]
    return _section(group.title, group.about, names, rows)


def _section(title: str, about: str, names: list[str], rows: list[list[str]]) -> str:
    return "\n\n".join(filter(None, [f"## {title}", about, markdown_table(names, rows)])) + "\n"
