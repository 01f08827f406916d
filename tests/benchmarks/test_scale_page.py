"""docs/scale.md says what was measured."""

import re

import pandas as pd
import pytest

from benchmarks.scale_page import (
    EPOCH,
    MEASURED,
    PAGE,
    PRICE,
    ROOT,
    filled,
    measured_table,
    plan_table,
)
from pipeline.params import load_params

UNITS = ("episodes", "questions of the exam", "control ticks", "windows")


def rates():
    """Work that takes a second a unit, and is shared by two processes without loss."""
    rows = [
        {"work": f"do {unit}", "unit": unit, "processes": processes, "units": units,
         "seconds": units / processes, "per_second": processes}
        for unit in UNITS for processes, units in ((1, 10), (1, 20), (2, 20))
    ]  # fmt: skip
    return pd.DataFrame(rows)


def test_work_is_told_once_twice_and_shared():
    first = measured_table(rates()).splitlines()[2]
    assert first == "| do episodes | episodes | 10 | 10.0 | 20 | 20.0 | 10.0 | 2.00 |"


@pytest.fixture
def plan():
    return plan_table(rates(), {"disk_bytes": 2_000, "memory_bytes": 50_000})


def numbers(plan):
    """The number of every row of a plan."""
    rows = [line.split("|") for line in plan.splitlines()[2:]]
    return {row[1].strip(): float(row[2].split()[0].replace(",", "")) for row in rows}


def test_a_plan_multiplies_what_was_measured(plan):
    assert "| simulate, write and cut them | 2,777.8 core-hours | grows |" in plan
    assert "| their tables on disk | 20 GB | grows |" in plan
    assert "| the memory of every process that trains | 500 GB | grows |" in plan


def test_a_plan_trains_as_long_as_the_laptop(plan):
    epochs = load_params(ROOT / "params.yaml").train_predictor.training.epochs
    told = numbers(plan)
    assert told[f"its {epochs} epochs"] == pytest.approx(epochs * told[EPOCH], rel=1e-3)


def test_a_plan_counts_everything_once_and_says_what_it_costs(plan):
    told = numbers(plan)
    rows = [line.split(" | ") for line in plan.splitlines() if "core-hours |" in line]
    parts = [told[row[0].removeprefix("| ")] for row in rows]
    assert told["all of that together"] == pytest.approx(sum(parts[:-1]) - told[EPOCH], abs=0.3)
    cost = told[f"at {PRICE:.2f} EUR a core-hour"]
    assert cost == pytest.approx(PRICE * told["all of that together"], abs=0.01)


def test_the_page_has_the_numbers_of_the_last_measurement():
    if not MEASURED.exists():
        pytest.skip("not measured yet; run `python -m benchmarks.scale`")
    page = PAGE.read_text(encoding="utf-8")
    assert filled(page) == page


def test_every_link_of_the_page_leads_somewhere():
    links = re.findall(r"\]\((?!https?:)([^)#]+)", PAGE.read_text(encoding="utf-8"))
    assert links
    assert [link for link in links if not (PAGE.parent / link).exists()] == []
