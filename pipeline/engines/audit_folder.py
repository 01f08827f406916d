"""The workflow of ``rallygap audit``: an engine in, a folder with its audit out."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rallygap.models.audit.audit import Audit
from rallygap.models.audit.bounces import SHELL, SOLID, Bounces
from rallygap.models.audit.traps import traps
from rallygap.models.engines.engine import Engine
from rallygap.pipeline.engines.audit_text import audit_content, effects_table, outcome, with_cost
from rallygap.pipeline.engines.audited import cached_audit
from rallygap.pipeline.engines.comparison import Comparison, compared, stated
from rallygap.pipeline.engines.load import load_engine, names_scene
from rallygap.pipeline.io.artifacts import replacing_files, write_json, write_text
from rallygap.pipeline.io.simulators import simulator_yaml
from rallygap.pipeline.runtime.paths import check_folder
from rallygap.pipeline.runtime.progress import PhaseBar
from rallygap.pipeline.web.environment import page_environment
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, MUTED, apply_style
from rallygap.pipeline.web.pages import page_table, shown_figure
from rallygap.pipeline.web.report_items import ReportFigure

TEMPLATES = Path(__file__).parent / "templates"
FIGURES = "figures"
FIGURE_NAMES = ("worth", "bounces")
PHASES = {"flying probes": 60, "comparing": 30, "writing": 10}
COLOUR = "#0f7fc4"
LEAST = 0.6  # restitution from which the axis begins, at least
ROW, HEADROOM = 0.35, 1.0  # inch


def audit_folder(name: str, out: Path, against: str | None = None) -> list[str]:
    """Audit an engine and write what it does; return the outcome in sentences.

    ``out`` gets audit.json, simulator.yaml, report.html and figures/*.png, all of them or none.

    Args:
        name: of the engine, as ``load_engine`` takes it.
        out: folder to write to.
        against: another engine to compare it with.

    Raises:
        InputError: there is no such engine, it fails, or the folder cannot be written to.
    """
    check_folder(out)
    engine, other = load_engine(name), load_engine(against) if against else None
    with PhaseBar(PHASES) as bar:
        with bar.phase("flying probes"):
            audit = cached_audit(engine, bar.reached)
        with bar.phase("comparing"):
            scene = _stated(engine, audit) if names_scene(name) else Comparison()
            comparison = compared(audit, other) if other else Comparison()
        with bar.phase("writing"):
            _write(name, audit, scene, comparison, out)
    notes = [f"Note: {note}" for note in scene.sentences]
    return [*outcome(name, audit, traps(audit)), *notes, *comparison.sentences]


def _stated(engine: Engine, audit: Audit) -> Comparison:
    from rallygap.models.engines.mujoco.scene import MujocoScene

    assert isinstance(engine, MujocoScene)  # by its name
    return stated(engine, audit)


def _write(name: str, audit: Audit, scene: Comparison, comparison: Comparison, out: Path) -> None:
    all_traps = traps(audit)
    content = audit_content(name, audit, all_traps) | {**scene.content, **comparison.content}
    simulator = simulator_yaml(audit.simulator)
    tables = {"effects": effects_table(audit), **scene.tables, **comparison.tables}
    page = {
        "name": name,
        "traps": [with_cost(trap.sentence, trap.cost_mm) for trap in all_traps],
        "outcome": [*outcome(name, audit, ()), *comparison.sentences],
        "notes": scene.sentences,
        "simulator": simulator,
        **dict.fromkeys(("says", "variants", "against")),
        **{table: page_table(columns) for table, columns in tables.items()},
    }
    with replacing_files(out, [f"{FIGURES}/{figure}.png" for figure in FIGURE_NAMES]) as folder:
        pictures = folder / FIGURES
        pictures.mkdir()
        apply_style()
        figures = list(_figures(audit))
        for figure in figures:
            figure.write(pictures / f"{figure.name}.png")
        shown = {figure.name: shown_figure(figure, pictures) for figure in figures}
        template = page_environment(TEMPLATES).get_template("audit.html")
        write_json(folder / "audit.json", content)
        write_text(folder / "simulator.yaml", simulator)
        write_text(folder / "report.html", template.render(**page, figures=shown))


def _figures(audit: Audit) -> Iterator[ReportFigure]:
    if any(np.isfinite(effect.worth_mm) for effect in audit.effects):
        yield _worth_figure(audit)
    if audit.bounces is not None:
        yield _bounces_figure(audit.bounces)


def _worth_figure(audit: Audit) -> ReportFigure:
    """Draw what each effect is worth, that is not of every engine; there is at least one."""
    shown = [effect for effect in audit.effects if np.isfinite(effect.worth_mm)]
    shown.sort(key=lambda effect: effect.worth_mm)
    figure = Figure(figsize=(FIGURE_WIDTH, HEADROOM + ROW * len(shown)))
    axes = figure.subplots()
    names = [effect.hypothesis.identity for effect in shown]
    axes.barh(names, [effect.worth_mm for effect in shown], 0.6, color=COLOUR)
    axes.set_xscale("symlog", linthresh=0.1)
    axes.set_xlim(left=0.0)
    axes.set_xlabel("distance without the effect (mm)")
    axes.grid(axis="y", visible=False)
    return ReportFigure(
        figure,
        "worth",
        title="What each effect is worth",
        caption="By how much the distance from the engine grows without an effect, the others "
        "fitted again: median over the probes, 0.4 s after the start of a flight, and 0.15 s "
        "after that of a bounce.",
    )


def _bounces_figure(bounces: Bounces) -> ReportFigure:
    """Draw restitution and grip of every bounce."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.0))
    left, right = figure.subplots(1, 2)
    left.plot(bounces.speed, bounces.restitution, "o", markersize=3, color=COLOUR)
    left.set_xlabel("normal speed before (m/s)")
    left.set_ylabel("restitution")
    left.set_ylim(min(LEAST, 0.95 * np.nanmin(bounces.restitution)), 1.05)
    right.plot(bounces.slip, bounces.grip, "o", markersize=3, color=COLOUR)
    for share, label in ((SHELL, "a shell rolls"), (SOLID, "a solid sphere rolls")):
        right.axhline(share, color=MUTED, lw=0.9, ls="--")
        right.annotate(label, (1.0, share), xycoords=("axes fraction", "data"), ha="right",
                       va="bottom", color=MUTED, fontsize="small")  # fmt: skip
    right.set_xlabel("slip before (m/s)")
    right.set_ylabel("change of velocity over slip")
    return ReportFigure(
        figure,
        "bounces",
        title="Bounces one by one",
        caption="Restitution, and the change of the velocity along the table over the slip of the "
        "contact point. Below the dashed lines the ball slides, on them it rolls.",
    )
