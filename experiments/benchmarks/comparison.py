"""Shared by benchmarks: rates in CPU time, comparisons with peers, and what is written.

``reports/costs/benchmarks.json`` has the last run of each comparison, with the machine.
"""

import platform
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import psutil
import torch
from rich.console import Console

from rallygap.pipeline.io.artifacts import read_json, write_csv, write_json
from rallygap.pipeline.runtime.torch_threads import one_thread

ROOT = Path(__file__).parents[2]
COSTS = ROOT / "reports" / "costs"
REPORT = COSTS / "benchmarks.json"
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
        lower_bound: of the ratio, where the peer did not reach the goal.
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
    """Return units of work per second of CPU time, of the fastest repeat after a warm-up."""
    work()
    rates = []
    for _ in range(REPEATS):
        start, done = time.process_time(), 0
        while (passed := time.process_time() - start) < MEASURED:
            done += work()
        rates.append(done / passed)
    return max(rates)


def report(benchmark: str, comparisons: Sequence[Comparison], **details: Any) -> None:
    """Print comparisons and details, and write them into the committed report."""
    reports = read_json(REPORT) if REPORT.is_file() else {}
    rows, numbers = [_rounded(asdict(comparison)) for comparison in comparisons], _rounded(details)
    reports[benchmark] = {**machine(), "comparisons": rows, "details": numbers}
    write_json(REPORT, dict(sorted(reports.items())))
    Console().print(pd.DataFrame(rows).to_string(index=False), numbers)


def write_measured(name: str, table: pd.DataFrame, **details: Any) -> None:
    """Write a table to ``reports/costs`` and print it; a JSON file has machine and details."""
    write_csv(COSTS / f"{name}.csv", table, digits=4)
    write_json(COSTS / f"{name}.json", {**machine(), **_rounded(details)})
    Console().print((COSTS / f"{name}.csv").read_text(), details)


def _rounded(values: dict[str, Any]) -> dict[str, Any]:
    return {k: float(f"{v:.4g}") if isinstance(v, float) else v for k, v in values.items()}


@contextmanager
def one_core() -> Iterator[None]:
    """Pin this process to one core, where the system supports it, and torch to one thread."""
    process = psutil.Process()
    cores = process.cpu_affinity() if hasattr(process, "cpu_affinity") else None
    if cores:
        process.cpu_affinity(cores[-1:])
    try:
        with one_thread():
            yield
    finally:
        if cores:
            process.cpu_affinity(cores)


def machine() -> dict[str, Any]:
    """Return the machine of the measurement."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {
        "cpu": models[0] if models else platform.processor(),
        "cores": psutil.cpu_count(logical=False) or psutil.cpu_count(),
        "torch": torch.__version__,
    }
