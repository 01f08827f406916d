"""What the code costs, from the measurements in reports/costs: tables of docs/scale.md, times."""

from pathlib import Path
from typing import Any

from rallygap.pipeline.documentation.cells import read_report
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.io.markdown import markdown_table
from rallygap.pipeline.params import load_params

COSTS = Path("reports") / "costs"
SHOTS = 10_000_000  # of the extrapolation
GIGABYTE = 1e9
CORE_HOUR = 0.05  # EUR, an assumption
EPOCH = "an epoch of the laptop's transformer"


def scale_table(root: Path) -> str:
    """Return the measured times: of the work, of twice the work, and of that on two processes."""
    rows = []
    for work, measured in read_report(root, "costs/scale.csv").groupby("work", sort=False):
        units = [f"{count:,}" for count in measured["units"]]
        once, twice, shared = measured["seconds"]
        cells = [units[0], f"{once:.1f}", units[1], f"{twice:.1f}", f"{shared:.1f}"]
        rows.append([work, measured["unit"].iloc[0], *cells, f"{twice / shared:.2f}"])
    head = ["work", "unit", "units", "s", "twice the units", "s", "on two processes (s)"]
    return markdown_table([*head, "speed-up"], rows)


def extrapolation_table(root: Path) -> str:
    """Return what ``SHOTS`` shots would cost at the measured rates of one process."""
    measured = read_report(root, "costs/scale.csv", "processes == 1")
    rates = measured.groupby("unit", sort=False)["per_second"].last()
    params = load_params(root / "params.yaml")
    training = params.train_predictor.training
    windows = SHOTS * training.windows_per_episode
    group = params.train_policy.groups["sim2sim"]
    policies = len(group.simulators) * len(group.horizons_ms) * group.repeats
    steps = policies * group.learning.iterations * group.learning.steps_per_iteration
    works = (
        ("simulate, write and segment them", SHOTS, "episodes", "yes"),
        (EPOCH, windows, "windows", "yes"),
        (f"its {training.epochs} epochs", training.epochs * windows, "windows", "yes"),
        ("the laptop's policies", steps, "control steps", "no"),
        ("1,000 verdicts on 100 shots", 1000, "questions of the exam", "no"),
    )
    hours = {name: units / rates[unit] / 3600 for name, units, unit, _ in works}
    total = sum(hours.values()) - hours[EPOCH]  # which all epochs contain
    sizes = read_json(root / COSTS / "scale.json")
    disk, memory = (SHOTS * sizes[name] / GIGABYTE for name in ("disk_bytes", "memory_bytes"))
    rows = [
        *([name, f"{hours[name]:,.1f} core-hours", grows] for name, *_, grows in works),
        ["total", f"{total:,.1f} core-hours", "yes"],
        [f"at {CORE_HOUR:.2f} EUR per core-hour", f"{CORE_HOUR * total:,.2f} EUR", "yes"],
        ["tables on disk", f"{disk:,.0f} GB", "yes"],
        ["memory of every training process", f"{memory:,.0f} GB", "yes"],
    ]
    return markdown_table(["work", "cost", "grows with the shots"], rows)


def benchmarks_table(root: Path) -> str:
    """Return the comparisons with peers of the last `make bench`."""
    measured = read_json(root / COSTS / "benchmarks.json").values()
    rows = [_comparison(one) for benchmark in measured for one in benchmark["comparisons"]]
    return markdown_table(["measure", "rallygap", "peer", "its value", "ratio"], rows)


def _comparison(one: dict[str, Any]) -> list[str]:
    ratio = "not reached" if one["ratio"] is None else f"{one['ratio']:,.1f}"
    bound = "more than " if one["lower_bound"] and one["ratio"] is not None else ""
    values = [f"{one['rallygap']:,.0f}", one["peer"], f"{one['peer_value']:,.0f}"]
    return [one["measure"], *values, f"{bound}{ratio}"]


def reproduction_time(root: Path) -> str:
    """Return how long `make reproduce` took on a clean clone, and what it changed."""
    measured = read_json(root / COSTS / "reproduce.json")
    machine = f"{measured['cores']} cores ({measured['cpu']})"
    minutes = f"{measured['seconds'] / 60:.0f} minutes on {machine}"
    changed = "left every committed byte unchanged"
    if measured["changed"]:
        changed = f"changed {len(measured['changed'])} committed files"
    return f"`make reproduce` took {minutes}, set-up included, and {changed}."
