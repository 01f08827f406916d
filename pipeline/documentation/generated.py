"""Documentation that is written from the code and from the committed runs.

A page in ``PAGES`` is generated whole. Any other page may have generated blocks: the text between
``<!-- generated: NAME -->`` and ``<!-- end -->`` is written by ``BLOCKS[NAME]``, on lines of its
own or inside a sentence or a table cell. `rallygap docs` writes both; a test checks that writing
them again changes nothing.
"""

import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from pipeline.documentation import deviations
from pipeline.documentation.command_page import command_page
from pipeline.documentation.cost_tables import (
    benchmarks_table,
    extrapolation_table,
    reproduction_time,
    scale_table,
)
from pipeline.documentation.diagnose_example import diagnose_example
from pipeline.documentation.effects_page import catalogue_page
from pipeline.documentation.kept_runs import age_of, kept_runs
from pipeline.documentation.physics_tables import constants_table, quantities_table
from pipeline.documentation.tables import gap, predictors, transfer
from pipeline.exam.page import questions_table
from pipeline.paper.page import claims_table, paper_page
from pipeline.runtime.errors import InputError

Writer = Callable[[Path], str]  # takes the repository's root, returns Markdown

PAGES: dict[str, Writer] = {
    "docs/command-line.md": command_page,
    "docs/effects.md": lambda root: catalogue_page(),
    "docs/paper.md": paper_page,
}

BLOCKS: dict[str, Writer] = {
    "benchmarks": benchmarks_table,
    "constants": lambda root: constants_table(),
    "exam-questions": questions_table,
    "quantities": lambda root: quantities_table(),
    **deviations.BLOCKS,
    "scale": scale_table,
    "scale-extrapolation": extrapolation_table,
    "gap-arena": gap.arena_causes,
    "gap-exam": gap.exam_rates,
    "gap-real": gap.real_summary,
    "gap-real-errors": gap.real_errors,
    "gap-real-causes": gap.real_causes,
    "gap-returns": gap.retrained_returns,
    "gap-returns-paper": partial(gap.retrained_returns, run="paper/"),
    "gap-returns-real": partial(gap.retrained_returns, run="real/"),
    "errors-by-group": predictors.errors_by_group,
    "errors-arena": partial(predictors.position_errors, arena=True),
    "errors-arena-paper": partial(predictors.position_errors, run="paper/", arena=True),
    "errors-real": partial(predictors.position_errors, run="real/", arena=False),
    "costs": predictors.predictor_costs,
    "sim2sim": transfer.sim2sim_returns,
    "sim2sim-paper": partial(transfer.sim2sim_returns, run="paper/"),
    "sim2real": transfer.sim2real_counts,
    "sim2real-paper": partial(transfer.sim2real_counts, run="paper/"),
    "sim2real-real": transfer.real_swap,
    "longer-trainings": transfer.longer_trainings,
    "kept-runs": kept_runs,
    "age-paper": partial(age_of, run="paper"),
    "age-real": partial(age_of, run="real"),
    "paper-claims": claims_table,
    "diagnose-example": diagnose_example,
    "reproduction-time": reproduction_time,
}

_START = "<!-- generated:"
_BLOCK = re.compile(r"(?P<start><!-- generated: (?P<name>\S+) -->)(?P<text>.*?)<!-- end -->", re.S)


def regenerate(root: Path) -> dict[Path, str]:
    """Return the text of every page of a repository that is generated or has generated blocks.

    Raises:
        InputError: a page names an unknown block or does not end one, or a report is broken.
    """
    pages = {root / name: write(root).rstrip() + "\n" for name, write in PAGES.items()}
    return pages | {path: _with_blocks(path, root) for path in _pages_with_blocks(root)}


def _pages_with_blocks(root: Path) -> Iterator[Path]:
    for path in [root / "README.md", *sorted((root / "docs").rglob("*.md"))]:
        generated = path.relative_to(root).as_posix() in PAGES
        if not generated and _START in path.read_text(encoding="utf-8"):
            yield path


def _with_blocks(path: Path, root: Path) -> str:
    def written(block: re.Match[str]) -> str:
        name = block["name"]
        if name not in BLOCKS:
            problem = f"names an unknown block, {name}; known are {', '.join(sorted(BLOCKS))}"
            raise InputError(path, problem)
        margin = "\n" if block["text"].startswith("\n") else ""
        return f"{block['start']}{margin}{BLOCKS[name](root).strip()}{margin}<!-- end -->"

    text, count = _BLOCK.subn(written, path.read_text(encoding="utf-8"))
    if count != text.count(_START):
        raise InputError(path, "has a generated block without a name or without <!-- end -->")
    return text
