"""Tables of live forecasts: latency, and how soon drift is noticed."""

from pathlib import Path

from rallygap.pipeline.documentation.cells import NONE, predictor_name
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.io.markdown import markdown_table

LIVE = Path("reports") / "live"


def latency(root: Path) -> str:
    """Latency of live forecasts, from ``python -m benchmarks.live``."""
    rows = [
        [
            predictor_name(name),
            *(f"{one[key]:.2f}" for key in ("p50_ms", "p99_ms", "eager_ms")),
            NONE if one["max_change_mm"] is None else f"{one['max_change_mm']:.2f}",
        ]
        for name, one in read_json(root / LIVE / "latency.json").items()
    ]
    heads = ["median (ms)", "99th percentile (ms)", "PyTorch without compilation, median (ms)"]
    return markdown_table(["predictor", *heads, "largest change (mm)"], rows)


def drift(root: Path) -> str:
    """Shots until a change is named, by its size, from ``python -m benchmarks.drift``."""
    found = read_json(root / LIVE / "drift.json")
    rows = []
    for cause, sizes in found["causes"].items():
        cells = []
        for one in sizes.values():
            soon = one["median_shots"]
            shots = NONE if soon is None else f"{soon:g}"
            cells.append(f"{shots}, {100 * one['named_right']:.0f} %")
        rows.append([f"`{cause}`", *cells])
    heads = [f"{size}: shots, named right" for size in next(iter(found["causes"].values()))]
    alarms = f"False alarms: {found['false_alarms']} in {found['shots']:,} shots without a change."
    return f"{alarms}\n\n{markdown_table(['changed', *heads], rows)}"
