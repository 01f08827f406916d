"""Tables of users' own simulators: published models, scenes, measured sets, round trips."""

from pathlib import Path
from typing import Any

from rallygap.pipeline.documentation.cells import ERRORS, HORIZON_HEADS, NONE, before_after
from rallygap.pipeline.engines.audit_text import with_cost
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.io.markdown import markdown_table

SIMULATORS = Path("reports") / "simulators"
ENDS = ("net", "out", "missed")  # of points
ENGINES = {"mujoco": "MuJoCo", "pybullet": "PyBullet"}


def published_table(root: Path) -> str:
    """What published models say and do: their traps, and their values."""
    rows = []
    for name, one in read_json(root / SIMULATORS / "published.json").items():
        values = ", ".join(f"`{each['identity']}` {each['value']:g}" for each in one["effects"])
        sentences = [with_cost(each["sentence"], each["cost_mm"]) for each in one["traps"]]
        place = f"[{name}](https://github.com/{name}), {one['file']}"
        rows.append([place, one["says"], " ".join(sentences), values])
    return markdown_table(["model", "stated parameters", "traps", "audited parameters"], rows)


def larger_spins_table(root: Path) -> str:
    """What games of the arena are like with larger spins, a row a level and factor."""
    rows = []
    for level, records in read_json(root / SIMULATORS / "larger_spins.json").items():
        for one in records:
            spins = f"{one['spin_median']:.0f}, {one['spin_p95']:.0f}"
            ends = ", ".join(f"{100 * one['ended_by'][kind]:.0f}" for kind in ENDS)
            bend, strokes = f"{one['bend_mm']:.0f}", f"{one['strokes_a_point']:.1f}"
            rows.append([level, f"{one['factor']:g}", spins, bend, strokes, ends])
    head = [
        "level",
        "factor of the spins",
        "median, 95th percentile (rad/s)",
        "lift moves the ball by (mm)",
    ]
    return markdown_table(
        [*head, "strokes per point", f"{', '.join(ENDS)} (% of all points)"], rows
    )


def scenes_table(root: Path) -> str:
    """What becomes of scenes with something wrong, a row a scene."""
    rows = []
    for engine, scenes in read_json(root / SIMULATORS / "scenes.json").items():
        for one in scenes.values():
            found = [_code(one["traps"]), one["verdict"], _code(one["leading"])]
            right = "yes" if one["named_right"] else "no"
            errors = before_after(one, digits=1)
            closed = f"{100 * one['removable_closed']:.0f} %"
            rows.append([ENGINES[engine], one["hidden"], *found, right, errors, closed])
    head = ["engine", "what is wrong", "traps", "verdict", "leading causes", "right"]
    return markdown_table([*head, "error (mm)", "gap closed"], rows)


def real_scenes_table(root: Path) -> str:
    """Errors of published scenes on measured sets before and after amending."""
    rows = []
    for name, scenes in read_json(root / SIMULATORS / "real.json").items():
        for scene, one in scenes.items():
            errors = [
                before_after(dict(zip(ERRORS, sizes, strict=True)))
                for sizes in zip(*(one[key] for key in ERRORS), strict=True)
            ]
            fall = "{:z.0f} to {:z.0f}".format(*one["fall_mm"])
            shots = ", ".join(map(str, one["shots"]))
            verdicts = ", ".join(one["verdicts"])
            rows.append([name, scene, shots, *errors, fall, verdicts, _code(_always(one))])
    head = ["set", "scene", "shots", *HORIZON_HEADS, "error falls by (mm)", "verdicts"]
    return markdown_table([*head, "leading in all"], rows)


def _always(one: Any) -> list[str]:
    """Return the causes that lead in all verdicts on a scene."""
    first, *others = one["leading"]
    return [name for name in first if all(name in some for some in others)]


def _code(names: list[str]) -> str:
    return ", ".join(f"`{one}`" for one in names) or NONE


def round_trip_table(root: Path) -> str:
    """Largest differences of lists that go into scenes and come back: parameters by kinds."""
    report = read_json(root / SIMULATORS / "round_trip.json")
    kinds = report["kinds"]
    first = next(iter(kinds.values()))["parameters"]
    names = [
        *first,
        *sorted({name for one in kinds.values() for name in one["parameters"]} - {*first}),
    ]
    heads = [f"{name} ({one['lists']} lists)" for name, one in kinds.items()]
    rows = [
        [f"`{name}`", *(_difference(one["parameters"].get(name)) for one in kinds.values())]
        for name in names
    ]
    return markdown_table(["parameter", *heads], rows)


def without_attribute(root: Path) -> str:
    """Parameters without attribute, and in how many lists the export names them."""
    report = read_json(root / SIMULATORS / "round_trip.json")
    return ", ".join(
        f"`{name}` {one['named']} of {one['lists']}"
        for name, one in report["without_attribute"].items()
    )


def _difference(found: dict[str, Any] | None) -> str:
    """Return a largest difference in percent, in bold where it misses the target."""
    if found is None:
        return NONE
    share = found["largest_difference"]
    shown = f"{100 * share:.3g} %" if share else "< 0.001 %"
    return shown if found["within_target"] else f"**{shown}**"
