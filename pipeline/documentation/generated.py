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

from rallygap.pipeline.documentation import (
    answers,
    arena_tables,
    code_pages,
    cost_tables,
    deviations,
    gap_tables,
    live_tables,
    predictor_tables,
    simulator_tables,
    sweep_tables,
    transfer_tables,
)
from rallygap.pipeline.documentation.known_answers import known_answers
from rallygap.pipeline.exam.page import questions_table
from rallygap.pipeline.paper.page import claims_table, paper_page
from rallygap.pipeline.runtime.errors import InputError

Writer = Callable[[Path], str]  # takes the repository's root, returns Markdown


PAGES: dict[str, Writer] = {
    "docs/command-line.md": code_pages.command_page,
    "docs/effects.md": code_pages.catalogue_page,
    "docs/paper.md": paper_page,
}

BLOCKS: dict[str, Writer] = {
    "constants": code_pages.constants_table,
    "quantities": code_pages.quantities_table,
    "exam-questions": questions_table,
    **deviations.BLOCKS,
    "benchmarks": cost_tables.benchmarks_table,
    "scale": cost_tables.scale_table,
    "scale-extrapolation": cost_tables.extrapolation_table,
    "reproduction-time": cost_tables.reproduction_time,
    "gap-arena": gap_tables.arena_causes,
    "gap-arena-paper-physics": partial(gap_tables.arena_causes, run="paper_physics/"),
    "gap-arena-verdict": gap_tables.arena_verdict,
    "arenas-causes": arena_tables.arena_causes_found,
    "arenas-coverage": arena_tables.arena_coverage,
    "arenas-coverage-share": arena_tables.arena_coverage_share,
    "arenas-by-arena": arena_tables.by_arena,
    "arenas-errors": arena_tables.arena_errors,
    "gap-exam": gap_tables.exam_rates,
    "gap-exam-robustness": gap_tables.robustness_rates,
    "gap-real": gap_tables.real_summary,
    "gap-real-errors": gap_tables.real_errors,
    "gap-real-stability": gap_tables.real_stability,
    "gap-real-causes": gap_tables.real_causes,
    "known-answers": known_answers,
    "errors-by-group": partial(predictor_tables.errors_by, column="group"),
    "errors-by-net": partial(predictor_tables.errors_by, column="net"),
    "coverage": predictor_tables.coverage,
    "errors-arena": partial(predictor_tables.position_errors, arena=True),
    "errors-arena-paper": partial(predictor_tables.position_errors, run="paper/", arena=True),
    "errors-arena-paper-physics": partial(
        predictor_tables.position_errors, run="paper_physics/", arena=True
    ),
    "errors-real": partial(predictor_tables.position_errors, run="real/", arena=False),
    "learning-curves-short": predictor_tables.learning_curves_short,
    "learning-curves": predictor_tables.learning_curves,
    "paper-network": predictor_tables.paper_network,
    "paper-network-training": predictor_tables.paper_network_training,
    "paper-network-short": predictor_tables.paper_network_short,
    "forecasts-real": predictor_tables.measured_forecasts,
    "forecast-differences-real": predictor_tables.measured_differences,
    "coverage-real": predictor_tables.measured_coverage,
    "published-models": simulator_tables.published_table,
    "larger-spins": simulator_tables.larger_spins_table,
    "simulator-scenes": simulator_tables.scenes_table,
    "real-scenes": simulator_tables.real_scenes_table,
    "round-trip": simulator_tables.round_trip_table,
    "round-trip-named": simulator_tables.without_attribute,
    "latency": live_tables.latency,
    "drift": live_tables.drift,
    "costs": predictor_tables.predictor_costs,
    "sim2sim-gains": transfer_tables.sim2sim_gains,
    "sim2sim": transfer_tables.sim2sim_returns,
    "sim2sim-paper": partial(transfer_tables.sim2sim_returns, run="paper/"),
    "sim2real": transfer_tables.sim2real_counts,
    "sim2real-paper": partial(transfer_tables.sim2real_counts, run="paper/"),
    "sim2real-paper-physics": partial(transfer_tables.both_readings, run="paper_physics/"),
    "sim2real-real": transfer_tables.real_swap,
    "shot-quality": transfer_tables.shot_quality,
    "spread-policies": transfer_tables.spread_policies,
    "when-the-swap-helps": answers.when_the_swap_helps,
    "when-a-learned-predictor-helps": answers.when_a_learned_predictor_helps,
    "what-naming-buys": answers.what_naming_buys,
    "swap-first-window": partial(transfer_tables.swap_readings, protocol="first_window"),
    "swap-every-tick": partial(transfer_tables.swap_readings, protocol="every_tick"),
    "swap-mechanism": transfer_tables.swap_mechanism,
    "swap-latency": transfer_tables.swap_latency,
    "swap-table-one": transfer_tables.swap_table_one,
    "swap-re-anchored": transfer_tables.swap_every_tick,
    "swap-retrained": transfer_tables.swap_retrained,
    "longer-trainings": transfer_tables.longer_trainings,
    "sweeps": sweep_tables.committed_sweeps,
    "sweeps-confirmed": sweep_tables.confirmed_sweeps,
    "paper-claims": claims_table,
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
        if not margin and block.string[: block.start()].endswith("\n"):
            problem = f"begins a line with the block {name}: Markdown takes the line for HTML"
            raise InputError(path, problem)
        return f"{block['start']}{margin}{BLOCKS[name](root).strip()}{margin}<!-- end -->"

    text, count = _BLOCK.subn(written, path.read_text(encoding="utf-8"))
    if count != text.count(_START):
        raise InputError(path, "has a generated block without a name or without <!-- end -->")
    return text
