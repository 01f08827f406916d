"""The page of a verdict: what was found, on what grounds, in one HTML file that works offline."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from models.gap.location import Located
from pipeline.gap.figures.verdict import KIND_NAMES
from pipeline.gap.summary import Findings
from pipeline.gap.wording import label, number, percent, with_unit
from pipeline.io.report_manifest import Column, read_figure
from pipeline.web.environment import page_environment

TEMPLATES = Path(__file__).parent / "templates"
SMALLEST_P = 1e-4  # of those that signs drawn at random can tell apart


@dataclass(frozen=True)
class Illustration:
    """A figure of the page: its file's name without the ending, its title and its caption."""

    name: str
    title: str
    caption: str


def render_gap_page(
    findings: Findings, amended: str, folder: Path, illustrations: Sequence[Illustration]
) -> str:
    """Render the page of a verdict; the same findings give the same text.

    Args:
        findings: the verdict and what it is about.
        amended: YAML of the amended simulator.
        folder: where the figures are.
        illustrations: the figures to show.

    Raises:
        InputError: a figure is missing.
    """
    verdict, located = findings.verdict, findings.verdict.located
    return (
        page_environment(TEMPLATES)
        .get_template("gap.html")
        .render(
            answer=verdict.verdict.replace("_", " "),
            sentences=findings.sentences,
            figures={one.name: _shown(one, folder) for one in illustrations},
            causes=_table(_causes(findings)) if verdict.effects else None,
            growth=_table(_growth(located)) if located and located.growth else None,
            errors=_table(_errors(findings)) if verdict.gap else None,
            closer=_closer(findings),
            detectable=_table(_detectable(findings)),
            blind=[f"{name}: {findings.title(name)}" for name in verdict.blind_to],
            limits=verdict.limits,
            amended=amended,
            facts=_facts(findings),
        )
    )


def _shown(one: Illustration, folder: Path) -> dict[str, str]:
    source = read_figure(folder / f"{one.name}.png")
    return {"title": one.title, "caption": one.caption, "source": source}


def _table(columns: dict[str, list[str]]) -> dict[str, Any]:
    """Return columns as the page's tables take them; those of numbers are marked by a blank."""
    shown = [
        Column(name.strip(), is_number=name.endswith(" "), cells=cells)
        for name, cells in columns.items()
    ]
    return {"columns": shown, "rows": range(len(shown[0].cells))}


def _causes(findings: Findings) -> dict[str, list[str]]:
    causes = findings.verdict.effects
    return {
        "cause": [label(one) for one in causes],
        "kind": [KIND_NAMES[one.kind] for one in causes],
        "simulator ": [number(one.nominal) for one in causes],
        "estimate ": [with_unit(one.estimate, one.unit) for one in causes],
        "95 % interval ": [" to ".join(map(number, one.interval)) for one in causes],
        "p ": [_chance(one.p_value) for one in causes],
        "share ": [percent(one.gap_share) for one in causes],
        "possible names": [", ".join(one.possible) for one in causes],
        "what would decide": [findings.splits(one) or "–" for one in causes],
    }


def _growth(located: Located) -> dict[str, list[str]]:
    return {
        "axis": [one.axis for one in located.growth],
        "bins ": [str(len(one.counts)) for one in located.growth],
        "share of the variance ": [percent(one.share) for one in located.growth],
        "p ": [_chance(one.p_value) for one in located.growth],
    }


def _errors(findings: Findings) -> dict[str, list[str]]:
    gap = findings.verdict.gap
    assert gap is not None  # the page has this table only where there is a gap
    rows = [
        (f"{horizon} ms ahead", *(f"{size:.1f} mm" for size in sizes))
        for horizon, *sizes in zip(
            gap.horizons_ms, gap.before_mm, gap.after_mm, gap.floor_mm, strict=True
        )
    ]
    if gap.landing:
        places, times = zip(*gap.landing.sizes, strict=True)
        rows.append(("where they land", *(f"{size:.1f} mm" for size in places)))
        rows.append(("when they land", *(f"{size:.2f} ms" for size in times)))
    names = ("prediction", "before ", "after ", "floor ")
    return dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))


def _closer(findings: Findings) -> str:
    """Return in words by how much landings got better."""
    landing = findings.verdict.gap.landing if findings.verdict.gap else None
    if not landing:
        return ""
    low, high = landing.closer_mm
    sooner, later = landing.closer_ms
    return (
        f"Of {landing.shots} balls that land, the amended simulator is nearer to the place by "
        f"{low:.1f} to {high:.1f} mm and to the time by {sooner:.2f} to {later:.2f} ms "
        "(95 %, shots drawn at random in pairs)."
    )


def _detectable(findings: Findings) -> dict[str, list[str]]:
    sizes = findings.verdict.detectable
    named = [findings.numbers[name] for name in sizes]
    return {
        "number": list(sizes),
        "what it is": [findings.title(name) for name in sizes],
        "smallest detectable size ": [number(size) for size in sizes.values()],
        "unit": [_unit(one.declaration.unit) for one in named],
        "simulator ": [
            number(one.value(findings.simulator)) if one.listed(findings.simulator) else "–"
            for one in named
        ],
    }


def _facts(findings: Findings) -> dict[str, str]:
    measured = findings.measured
    labelled = int(measured.shots.labelled.any(axis=1).sum())
    return {
        "data": measured.name,
        "recordings": f"{measured.recordings:,}",
        "rows and labels refused": _refused(measured.refused),
        "episodes in them": f"{measured.episodes:,}",
        "shots that served": f"{len(measured.shots):,}",
        "shots with spin labels": f"{labelled:,}",
        "noise by which they were cut": f"{1000 * measured.noise:.1f} mm",
        "simulator": findings.called,
        "chance of a false name": f"{100 * findings.level:g} %",
    }


def _refused(refused: dict[str, int]) -> str:
    return ", ".join(f"{count:,} {reason}" for reason, count in refused.items()) or "none"


def _unit(unit: str) -> str:
    return "–" if unit == "1" else unit


def _chance(p_value: float) -> str:
    return f"< {SMALLEST_P:g}" if p_value < SMALLEST_P else f"{p_value:.2g}"
