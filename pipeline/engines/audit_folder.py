"""The workflow of ``rallygap audit``: an engine in, a folder with its audit out."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rallygap.models.audit.audit import Audit
from rallygap.models.audit.traps import Trap, traps
from rallygap.models.engines.engine import Engine
from rallygap.pipeline.engines.audit_text import audit_content, effects_table, outcome, with_cost
from rallygap.pipeline.engines.audited import cached_audit
from rallygap.pipeline.engines.comparison import Comparison, StatedScene
from rallygap.pipeline.engines.figures import bounces_figure, worth_figure
from rallygap.pipeline.engines.load import load_engine, names_scene
from rallygap.pipeline.io.artifacts import replacing_files, write_json, write_text
from rallygap.pipeline.io.simulators import simulator_yaml
from rallygap.pipeline.runtime.paths import check_folder
from rallygap.pipeline.runtime.progress import phase_bar
from rallygap.pipeline.web.environment import page_environment
from rallygap.pipeline.web.figure_style import apply_style
from rallygap.pipeline.web.pages import page_table, shown_figure
from rallygap.pipeline.web.report_items import ReportFigure

TEMPLATES = Path(__file__).parent / "templates"
FIGURES = "figures"
FIGURE_NAMES = ("worth", "bounces")
PHASES = {"flying probes": 60, "comparing": 30, "writing": 10}


@dataclass(frozen=True)
class AuditFindings:
    """An audit and what belongs to it.

    Attributes:
        name: of the engine.
        audit: of the engine.
        traps: in it.
        scene: what its file states, where it is a scene.
        comparison: with another engine, if there is one.
    """

    name: str
    audit: Audit
    traps: tuple[Trap, ...]
    scene: StatedScene | None
    comparison: Comparison | None

    @property
    def lines(self) -> list[str]:
        """What the terminal shows."""
        notes = self.scene.notes if self.scene else ()
        return [
            *outcome(self.name, self.audit, self.traps),
            *(f"Note: {note}" for note in notes),
            *self._compared,
        ]

    @property
    def content(self) -> dict[str, Any]:
        """The content of ``audit.json``."""
        content = audit_content(self.name, self.audit, self.traps)
        if self.scene:
            content |= self.scene.content()
        if self.comparison:
            content["against"] = self.comparison.content()
        return content

    @property
    def page(self) -> dict[str, Any]:
        """What the page shows, but for its figures."""
        scene, comparison = self.scene, self.comparison
        return {
            "name": self.name,
            "traps": [with_cost(trap.sentence, trap.cost_mm) for trap in self.traps],
            "outcome": [*outcome(self.name, self.audit, ()), *self._compared],
            "effects": page_table(effects_table(self.audit)),
            "says": page_table(scene.table()) if scene else None,
            "variants": page_table(scene.variants_table()) if scene else None,
            "notes": scene.notes if scene else (),
            "against": page_table(comparison.table()) if comparison else None,
        }

    @property
    def _compared(self) -> list[str]:
        return self.comparison.sentences() if self.comparison else []


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
    with phase_bar(PHASES) as bar:
        with bar.phase("flying probes"):
            audit = cached_audit(engine, bar.reached)
        with bar.phase("comparing"):
            scene = _stated(engine, audit) if names_scene(name) else None
            comparison = Comparison.of(audit, other) if other else None
            findings = AuditFindings(name, audit, traps(audit), scene, comparison)
        with bar.phase("writing"):
            _write(findings, out)
    return findings.lines


def _stated(engine: Engine, audit: Audit) -> StatedScene:
    from rallygap.models.engines.mujoco.scene import MujocoScene

    assert isinstance(engine, MujocoScene)  # by its name
    return StatedScene.of(engine, audit)


def _write(findings: AuditFindings, out: Path) -> None:
    with replacing_files(out, [f"{FIGURES}/{name}.png" for name in FIGURE_NAMES]) as folder:
        pictures = folder / FIGURES
        pictures.mkdir()
        apply_style()
        figures = list(_figures(findings.audit))
        for figure in figures:
            figure.write(pictures / f"{figure.name}.png")
        shown = {figure.name: shown_figure(figure, pictures) for figure in figures}
        simulator = simulator_yaml(findings.audit.simulator)
        template = page_environment(TEMPLATES).get_template("audit.html")
        write_json(folder / "audit.json", findings.content)
        write_text(folder / "simulator.yaml", simulator)
        page = template.render(**findings.page, figures=shown, simulator=simulator)
        write_text(folder / "report.html", page)


def _figures(audit: Audit) -> Iterator[ReportFigure]:
    if any(np.isfinite(effect.worth_mm) for effect in audit.effects):
        yield worth_figure(audit)
    if audit.bounces is not None:
        yield bounces_figure(audit.bounces)
