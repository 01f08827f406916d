"""The tables of docs/scale.md, from what benchmarks/scale.py measured."""

import re
from pathlib import Path

import pandas as pd

from pipeline.io.artifacts import read_json, write_text
from pipeline.params import load_params

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "scale.md"
MEASURED = ROOT / "reports" / "costs" / "scale.csv"
SIZES = ROOT / "reports" / "costs" / "scale.json"
MANY = 10_000_000  # shots of the plan
GIGABYTE = 1e9
PRICE = 0.05  # EUR a core-hour: an assumption, as the page says
EPOCH = "an epoch of the laptop's transformer"


def measured_table(measured: pd.DataFrame) -> str:
    """Return what was measured: the work, twice the work, and that on two processes."""
    lines = [
        "| work | unit | units | s | twice the units | s | on two processes (s) | times as fast |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for work, rows in measured.groupby("work", sort=False):
        once, twice, shared = rows.itertuples()
        cells = [f"{once.units:,}", f"{once.seconds:.1f}", f"{twice.units:,}"]
        cells += [f"{twice.seconds:.1f}", f"{shared.seconds:.1f}"]
        cells += [f"{twice.seconds / shared.seconds:.2f}"]
        lines.append(f"| {work} | {once.unit} | {' | '.join(cells)} |")
    return "\n".join(lines)


def plan_table(measured: pd.DataFrame, sizes: dict[str, float]) -> str:
    """Return what many shots take at the rates of one process."""
    alone = measured[measured["processes"] == 1].groupby("unit", sort=False)["per_second"].last()
    params = load_params(ROOT / "params.yaml")
    training = params.train_predictor.training
    windows = MANY * training.windows_an_episode
    group = params.train_policy.groups["sim2sim"]
    policies = len(group.simulators) * len(group.horizons_ms) * group.repeats
    ticks = policies * group.learning.legs * group.learning.ticks
    works = (
        ("simulate, write and cut them", MANY, "episodes", "grows"),
        (EPOCH, windows, "windows", "grows"),
        (f"its {training.epochs} epochs", training.epochs * windows, "windows", "grows"),
        ("the laptop's policies", ticks, "control ticks", "stays"),
        ("1,000 verdicts on 100 shots", 1000, "questions of the exam", "stays"),
    )
    lines = ["| what | how much | with the shots it |", "|---|---|---|"]
    hours = {what: units / alone[unit] / 3600 for what, units, unit, _ in works}
    lines += [
        f"| {what} | {hours[what]:,.1f} core-hours | {growth} |" for what, *_, growth in works
    ]
    total = sum(hours.values()) - hours[EPOCH]  # which is one of all epochs
    lines.append(f"| all of that together | {total:,.1f} core-hours | grows |")
    lines.append(f"| at {PRICE:.2f} EUR a core-hour | {PRICE * total:,.2f} EUR | grows |")
    disk, memory = (MANY * sizes[name] / GIGABYTE for name in ("disk_bytes", "memory_bytes"))
    lines.append(f"| their tables on disk | {disk:,.0f} GB | grows |")
    lines.append(f"| the memory of every process that trains | {memory:,.0f} GB | grows |")
    return "\n".join(lines)


def filled(page: str) -> str:
    """Return the page with its two tables as they were measured."""
    measured, sizes = pd.read_csv(MEASURED), read_json(SIZES)
    for name, table in (
        ("measured", measured_table(measured)),
        ("plan", plan_table(measured, sizes)),
    ):
        marks = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)", re.DOTALL)
        page = marks.sub(lambda found, table=table: f"{found[1]}{table}\n{found[2]}", page)
    return page


def fill_page() -> None:
    """Fill in docs/scale.md."""
    write_text(PAGE, filled(PAGE.read_text(encoding="utf-8")))


if __name__ == "__main__":
    fill_page()
