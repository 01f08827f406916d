"""Shared by benchmarks: rates in CPU time, and the report of comparisons with peers.

``reports/costs/benchmarks.json`` has the last run of each benchmark, with machine and commit.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from rallygap.pipeline.evaluation.costs import machine
from rallygap.pipeline.io.artifacts import read_json, write_json

ROOT = Path(__file__).parents[1]
REPORT = ROOT / "reports" / "costs" / "benchmarks.json"
MEASURED = 1.0  # s of CPU time, at least, of every measurement
REPEATS = 3  # of which the fastest counts


@dataclass(frozen=True)
class Comparison:
    """One measure of rallygap and of a peer, in the same run.

    Attributes:
        measure: with its unit.
        rallygap: its value.
        peer: the name of the other program.
        peer_value: its value.
        ratio: how many times better rallygap is; None if it did not reach the goal.
        lower_bound: the peer did not reach the goal, so that the ratio is a lower bound.
    """

    measure: str
    rallygap: float
    peer: str
    peer_value: float
    ratio: float | None
    lower_bound: bool = False


def faster(measure: str, rallygap: float, peer: str, peer_value: float) -> Comparison:
    """Compare two rates."""
    return Comparison(measure, rallygap, peer, peer_value, rallygap / peer_value)


def rate(work: Callable[[], int]) -> float:
    """Return units of work per second of CPU time, of the fastest repeat after a warm-up.

    CPU time depends little on what else the machine does.

    Args:
        work: does some units and returns how many.
    """
    work()
    return max(_rate(work) for _ in range(REPEATS))


def _rate(work: Callable[[], int]) -> float:
    start, done = time.process_time(), 0
    while (passed := time.process_time() - start) < MEASURED:
        done += work()
    return done / passed


def report(benchmark: str, comparisons: Sequence[Comparison], **details: float) -> None:
    """Print comparisons and details, and write them into the committed report."""
    reports = read_json(REPORT) if REPORT.is_file() else {}
    rows = [{name: _rounded(value) for name, value in asdict(one).items()} for one in comparisons]
    numbers = {name: _rounded(value) for name, value in details.items()}
    reports[benchmark] = {**machine(ROOT), "comparisons": rows, "details": numbers}
    write_json(REPORT, dict(sorted(reports.items())))
    console = Console()
    console.print(comparison_table(comparisons))
    for name, value in numbers.items():
        console.print(f"{name.replace('_', ' ')}: {value}")


def _rounded(value: Any) -> Any:
    return float(f"{value:.4g}") if isinstance(value, float) else value


def comparison_table(comparisons: Sequence[Comparison]) -> Table:
    """Return comparisons as a table for the terminal."""
    table = Table("measure", "rallygap", "peer", "peer's value", "ratio")
    for one in comparisons:
        ratio = "not reached" if one.ratio is None else f"{one.ratio:,.1f}"
        bound = "more than " if one.lower_bound and one.ratio is not None else ""
        values = (f"{one.rallygap:,.4g}", one.peer, f"{one.peer_value:,.4g}", f"{bound}{ratio}")
        table.add_row(one.measure, *values)
    return table
