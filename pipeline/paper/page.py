"""docs/paper.md: the paper number by number, in Markdown."""

from pathlib import Path

from pipeline.paper.catalogue import EXHIBITS, GROUPS, findings
from pipeline.paper.entries import NOTHING, Entry, Finding, Group, with_unit
from pipeline.paper.judgements import DIFFERS, MEANINGS
from pipeline.paper.prediction_accuracy import LEARNED
from pipeline.paper.printed_settings import NETWORK, TRAINING
from pipeline.paper.run_reports import Reports, laptop_reports, paper_reports

PREDICTORS = "evaluate_predictor/predictors.csv"

PREAMBLE = """# The paper, number by number

*Bridging the sim2real gap in the table tennis robot with a transformer-based ball states predictor*
(Bi, Conti, Yang, Sigrist, Dürr, Takahashi; Sony AI): each of its figures, tables and printed
numbers, the stage that makes ours, and how the two compare. Written from the reports by
`rallygap docs`; `reports/index.html` draws the same.

- *laptop* is the last run (`reports/`), *paper* the one with the paper's balls (`reports/paper/`,
  whose `run.json` has the command and the sizes).
- Intervals are of 95 %. A dash: not there. Balls, arm and policy are others than the paper's:
  what can be set beside each other are differences and their signs ([deviations](deviations.md)).
"""

NOT_RUN = """- `reports/paper/` is not there: its columns have settings alone. To fill it:
  `dvc exp run --name paper $(rallygap profile paper)`, `rallygap keep paper`.
"""

SMALLER = """- The column *paper* is the profile `two_cores`: the paper's number of balls, but a
  transformer {width} of {width_printed} wide ({numbers} trained numbers) that learned for
  {epochs} of {epochs_printed} epochs. The profile `paper`, with the paper's network and training,
  has not been run: `dvc exp run --name paper $(rallygap profile paper)`, `rallygap keep paper`.
"""


def paper_page(root: Path) -> str:
    """Return the comparison of a repository's reports with the paper as Markdown.

    Raises:
        InputError: a report is broken.
    """
    laptop, paper = laptop_reports(root), paper_reports(root)
    found = findings(laptop), findings(paper)
    parts = [PREAMBLE + _size(paper, found[1]), _words(), _exhibits(laptop, paper)]
    parts += [_group(group, *found) for group in GROUPS]
    return "\n".join(parts).rstrip()


def _size(paper: Reports, found: dict[str, Finding]) -> str:
    """Return what the column `paper` is, where it is not the profile `paper`."""
    if not paper.folder.is_dir():
        return NOT_RUN
    width, epochs = f"setting.{NETWORK}.width", f"setting.{TRAINING}.epochs"
    if found[width].verdict != DIFFERS:
        return ""
    printed = {entry.key: entry.paper for group in GROUPS for entry in group.entries}
    return SMALLER.format(
        width=with_unit(found[width].value, ""),
        width_printed=printed[width],
        numbers=with_unit(paper.number(PREDICTORS, "parameters", predictor=LEARNED), ""),
        epochs=with_unit(found[epochs].value, ""),
        epochs_printed=printed[epochs],
    )


def _words() -> str:
    rows = [[f"*{word}*", meaning] for word, meaning in MEANINGS.items()]
    return _table("Verdicts", "", ["word", "means"], rows)


def _exhibits(laptop: Reports, paper: Reports) -> str:
    rows = [
        [one.name, one.what, _code(one.stage), one.ours, one.verdict(laptop), one.verdict(paper)]
        for one in EXHIBITS
    ]
    names = ["in the paper", "what", "stage", "ours", "verdict: laptop", "verdict: paper"]
    about = "Paths are relative to `reports/`. A figure's verdict is that of all its claims below."
    return _table("Figures and tables", about, names, rows)


def _group(group: Group, laptop: dict[str, Finding], paper: dict[str, Finding]) -> str:
    rows = [_row(entry, laptop[entry.key], paper[entry.key]) for entry in group.entries]
    names = ["what", "stage: ours in", "the paper", "laptop", "verdict", "paper", "verdict"]
    return _table(group.title, group.about, names, rows)


def _row(entry: Entry, laptop: Finding, paper: Finding) -> list[str]:
    source = f"{_code(entry.stage)}: {entry.where}"
    return [entry.what, source, entry.paper, *_ours(entry, laptop), *_ours(entry, paper)]


def _ours(entry: Entry, found: Finding) -> tuple[str, str]:
    return entry.ours(found), found.verdict


def _code(name: str) -> str:
    return name if name == NOTHING else f"`{name}`"


def _table(title: str, about: str, names: list[str], rows: list[list[str]]) -> str:
    lines = [f"## {title}", ""]
    lines += [about, ""] if about else []
    lines += [f"| {' | '.join(names)} |", "|" + "---|" * len(names)]
    lines += [f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |" for row in rows]
    return "\n".join([*lines, ""])
