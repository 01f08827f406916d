"""The workflow of ``rallygap audit``: an engine in, a folder with its audit out."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from rallygap.models.audit.audit import Audit
from rallygap.models.audit.traps import traps
from rallygap.models.engines.engine import Engine
from rallygap.pipeline.engines.audited import audited
from rallygap.pipeline.engines.comparison import Comparison
from rallygap.pipeline.engines.figures import bounces_figure, worth_figure
from rallygap.pipeline.engines.findings import AuditFindings
from rallygap.pipeline.engines.load import load_engine, names_scene
from rallygap.pipeline.engines.scene_audit import SceneAudit
from rallygap.pipeline.io.artifacts import replacing_files, write_json, write_text
from rallygap.pipeline.io.simulators import simulator_yaml
from rallygap.pipeline.runtime.paths import check_folder
from rallygap.pipeline.runtime.progress import phase_bar
from rallygap.pipeline.web.environment import page_environment
from rallygap.pipeline.web.figure_style import apply_style
from rallygap.pipeline.web.items import shown_figure
from rallygap.pipeline.web.report_items import ReportFigure

TEMPLATES = Path(__file__).parent / "templates"
FIGURES = "figures"
FIGURE_NAMES = ("worth", "bounces")
PHASES = {"flying probes": 60, "comparing": 30, "writing": 10}


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
            found = audited(engine, bar.reached)
        with bar.phase("comparing"):
            scene = _scene(engine, found) if names_scene(name) else None
            comparison = Comparison.of(found, other) if other else None
            findings = AuditFindings(name, found, traps(found), scene, comparison)
        with bar.phase("writing"):
            _write(findings, out)
    return findings.lines


def _scene(engine: Engine, found: Audit) -> SceneAudit:
    from rallygap.models.engines.mujoco.scene import MujocoScene

    assert isinstance(engine, MujocoScene)  # by its name
    return SceneAudit.of(engine, found)


def _write(findings: AuditFindings, out: Path) -> None:
    with replacing_files(out, [f"{FIGURES}/{one}.png" for one in FIGURE_NAMES]) as folder:
        pictures = folder / FIGURES
        pictures.mkdir()
        apply_style()
        figures = list(_figures(findings.audit))
        for figure in figures:
            figure.write(pictures / f"{figure.name}.png")
        shown = {one.name: shown_figure(one, pictures) for one in figures}
        simulator = simulator_yaml(findings.audit.simulator)
        template = page_environment(TEMPLATES).get_template("audit.html")
        write_json(folder / "audit.json", findings.content)
        write_text(folder / "simulator.yaml", simulator)
        page = template.render(**findings.page, figures=shown, simulator=simulator)
        write_text(folder / "report.html", page)


def _figures(found: Audit) -> Iterator[ReportFigure]:
    if any(np.isfinite(one.worth_mm) for one in found.effects):
        yield worth_figure(found)
    if found.bounces is not None:
        yield bounces_figure(found.bounces)
