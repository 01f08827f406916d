"""The page of a verdict: one HTML file that works offline."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.verdict import Cause, Gap, Verdict
from rallygap.pipeline.gap.summary import (
    ROLES,
    Findings,
    answer_title,
    episodes_text,
    labels_text,
    minor_causes,
    reasons_text,
    title,
)
from rallygap.pipeline.web.environment import page_environment
from rallygap.pipeline.web.labels import KIND_NAMES
from rallygap.pipeline.web.numbers import interval_text, number, percent, with_unit
from rallygap.pipeline.web.pages import page_table, shown_figure
from rallygap.pipeline.web.report_items import ReportFigure

TEMPLATES = Path(__file__).parent / "templates"
SMALLEST_P = 1e-4  # that permutations resolve
CHECKED = {
    "residuals": "residuals of held-out shots",
    "prediction": "prediction errors",
    "landing": "errors of predicted landings",
    "labels": "errors of spin labels, in units of the spin",
    "bounces": "standard deviation of the restitution",
}


def render_gap_page(
    findings: Findings, amended: str, folder: Path, figures: Sequence[ReportFigure]
) -> str:
    """Render the page of a verdict, with written figures of a folder.

    Raises:
        InputError: a figure is missing.
    """
    verdict, gap = findings.verdict, findings.verdict.gap
    template = page_environment(TEMPLATES).get_template("gap.html")
    return template.render(
        answer=answer_title(verdict).lower(),
        outcome=findings.outcome,
        details=findings.details,
        figures={figure.name: shown_figure(figure, folder) for figure in figures},
        **_tables(verdict),
        errors=page_table(_errors(gap)) if gap else None,
        reduction=_reduction(gap),
        detectable=page_table(_detectable(findings)),
        not_identifiable=[
            f"{identity}: {title(identity)}" for identity in verdict.not_identifiable
        ],
        limitations=verdict.limitations,
        amended=amended,
        facts=_facts(findings),
    )


def _tables(verdict: Verdict) -> dict[str, Any]:
    """Return tables by name; None in place of one that would have no row."""
    causes, minor, checks = verdict.main_causes, minor_causes(verdict), verdict.checks
    growth = verdict.located.growth if verdict.located else ()
    tables = {
        "checks": {
            "check": [CHECKED[check.name] for check in checks],
            "measured / expected ": [f"{check.ratio:.3g}" for check in checks],
            "95 % interval ": [_range(check.interval) for check in checks],
            "allowed ": [_range(check.allowed) for check in checks],
            "passed": ["yes" if check.passed else "no" for check in checks],
        },
        "causes": {
            "cause": [cause.identity for cause in causes],
            "role": [ROLES[cause.role] for cause in causes],
            "kind": [KIND_NAMES[cause.kind] for cause in causes],
            **_sizes(causes),
            "p ": [_p_cell(cause.p_value) for cause in causes],
            "not separable from": [", ".join(cause.alternatives) or "–" for cause in causes],
        },
        "minor": {"parameter": [cause.identity for cause in minor], **_sizes(minor)},
        "growth": {
            "covariate": [trend.covariate for trend in growth],
            "bins ": [str(len(trend.centres)) for trend in growth],
            "share of the variance ": [percent(trend.share) for trend in growth],
            "p ": [_p_cell(trend.p_value) for trend in growth],
        },
    }
    return {
        name: page_table(columns) if any(columns.values()) else None
        for name, columns in tables.items()
    }


def _sizes(causes: Sequence[Cause]) -> dict[str, list[str]]:
    worths = [
        f"{cause.worth.mm:.1f} ({cause.worth.interval[0]:.1f} to {cause.worth.interval[1]:.1f})"
        if cause.worth
        else "–"
        for cause in causes
    ]
    return {
        "simulator ": [number(cause.nominal) for cause in causes],
        "estimate ": [with_unit(cause.estimate, cause.unit) for cause in causes],
        "95 % interval ": [interval_text(cause.interval) for cause in causes],
        "worth (mm) ": worths,
        "share of the gap ": [percent(cause.gap_share) for cause in causes],
    }


def _errors(gap: Gap) -> dict[str, list[str]]:
    errors = zip(gap.horizons_ms, gap.before_mm, gap.after_mm, gap.floor_mm, strict=True)
    rows = [
        (f"position, {horizon} ms ahead", *(f"{size:.1f} mm" for size in sizes))
        for horizon, *sizes in errors
    ]
    if gap.landing:
        distances, times = zip(*gap.landing.sizes, strict=True)
        rows.append(("landing position", *(f"{size:.1f} mm" for size in distances)))
        rows.append(("landing time", *(f"{size:.2f} ms" for size in times)))
    names = ("prediction of", "nominal ", "amended ", "floor ")
    return dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))


def _reduction(gap: Gap | None) -> str:
    """Return the reduction of the landing error as a sentence."""
    if not gap or not gap.landing:
        return ""
    low, high = gap.landing.reduction_mm
    earliest, latest = gap.landing.reduction_ms
    return (
        f"Over {gap.landing.shots} landings the error is reduced by {low:.1f} to {high:.1f} mm and "
        f"{earliest:.2f} to {latest:.2f} ms (95 %, paired bootstrap over shots)."
    )


def _detectable(findings: Findings) -> dict[str, list[str]]:
    sizes = findings.verdict.minimum_detectable
    simulator, hypotheses = findings.simulator, [*map(Hypothesis.from_identity, sizes)]
    units = [hypothesis.declaration.unit for hypothesis in hypotheses]
    return {
        "parameter": list(sizes),
        "effect": [title(identity) for identity in sizes],
        "minimum detectable effect ": [number(size) for size in sizes.values()],
        "unit": ["–" if unit == "1" else unit for unit in units],
        "simulator ": [
            number(hypothesis.value(simulator)) if hypothesis.listed(simulator) else "–"
            for hypothesis in hypotheses
        ],
    }


def _facts(findings: Findings) -> dict[str, str]:
    measured, level = findings.measured, findings.settings.level
    labelled = int(measured.shots.labelled.any(axis=1).sum())
    return {
        "data": measured.name,
        "recordings": f"{measured.recordings:,}",
        "rows and labels rejected": reasons_text(measured.refused) or "none",
        "episodes used": episodes_text(measured),
        "spin labels used": labels_text(measured.labels),
        "shots with spin labels": f"{labelled:,}",
        "position noise": f"{1000 * measured.noise:.1f} mm",
        "simulator": findings.simulator_name,
        "level": f"{100 * level:g} % probability of a false cause where there is no gap",
    }


def _range(ends: tuple[float, float]) -> str:
    return f"{ends[0]:.3g} to {ends[1]:.3g}"


def _p_cell(p_value: float) -> str:
    return f"< {SMALLEST_P:g}" if p_value < SMALLEST_P else f"{p_value:.2g}"
