"""The workflow of ``rallygap audit``: an engine in, a folder with its audit out."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from models.audit.audit import Audit
from models.audit.traps import Trap, traps
from models.engines.engine import Engine
from pipeline.engines.audit_text import audit_content, effects_table, outcome, sentence
from pipeline.engines.audited import audited
from pipeline.engines.figures import bounces_figure, worth_figure
from pipeline.engines.load import load_engine, names_scene
from pipeline.engines.scene_audit import SceneAudit
from pipeline.io.artifacts import replacing_files, write_json, write_text
from pipeline.io.figure_style import apply_style
from pipeline.io.report_items import ReportFigure
from pipeline.io.simulators import simulator_yaml
from pipeline.runtime.paths import check_folder
from pipeline.runtime.progress import phase_bar
from pipeline.web.environment import page_environment
from pipeline.web.items import page_table, shown_figure

TEMPLATES = Path(__file__).parent / "templates"
FIGURES = "figures"
FIGURE_NAMES = ("worth", "bounces")
PHASES = {"flying probes": 90, "writing": 10}


def audit_folder(name: str, out: Path) -> list[str]:
    """Audit an engine and write what it does; return the outcome in sentences.

    ``out`` gets audit.json, simulator.yaml, report.html and figures/*.png, all of them or none.

    Args:
        name: of the engine, as ``load_engine`` takes it.
        out: folder to write to.

    Raises:
        InputError: there is no such engine, it fails, or the folder cannot be written to.
    """
    check_folder(out)
    engine = load_engine(name)
    with phase_bar(PHASES) as bar:
        with bar.phase("flying probes"):
            found = audited(engine, bar.reached)
        with bar.phase("writing"):
            known = traps(found)
            scene = _scene(engine) if names_scene(name) else None
            _write(name, found, known, scene, out)
    notes = [f"Note: {one}" for one in scene.notes] if scene else []
    return [*outcome(name, found, known), *notes]


def _scene(engine: Engine) -> SceneAudit:
    from models.engines.mujoco.scene import MujocoScene

    assert isinstance(engine, MujocoScene)  # by its name
    return SceneAudit.of(engine)


def _write(
    name: str, found: Audit, known: tuple[Trap, ...], scene: SceneAudit | None, out: Path
) -> None:
    with replacing_files(out, [f"{FIGURES}/{one}.png" for one in FIGURE_NAMES]) as folder:
        pictures = folder / FIGURES
        pictures.mkdir()
        apply_style()
        figures = list(_figures(found))
        for figure in figures:
            figure.write(pictures / f"{figure.name}.png")
        simulator = simulator_yaml(found.simulator)
        content = audit_content(name, found, known)
        write_json(folder / "audit.json", content | (scene.content() if scene else {}))
        write_text(folder / "simulator.yaml", simulator)
        page = (
            page_environment(TEMPLATES)
            .get_template("audit.html")
            .render(
                name=name,
                traps=[sentence(one) for one in known],
                outcome=outcome(name, found, ()),
                effects=page_table(effects_table(found)),
                figures={one.name: shown_figure(one, pictures) for one in figures},
                simulator=simulator,
                says=page_table(scene.says_and_does(found)) if scene else None,
                variants=page_table(scene.variants_table()) if scene else None,
                notes=scene.notes if scene else (),
            )
        )
        write_text(folder / "report.html", page)


def _figures(found: Audit) -> Iterator[ReportFigure]:
    if any(np.isfinite(one.worth_mm) for one in found.effects):
        yield worth_figure(found)
    if found.bounces is not None:
        yield bounces_figure(found.bounces)
