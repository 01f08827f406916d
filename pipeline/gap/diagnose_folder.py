"""The workflow of ``rallygap diagnose``: a folder of recordings in, a folder with a verdict out."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.amend.simulator import amended, amended_yaml
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.gap.settings import DEFAULTS, GapSettings
from rallygap.pipeline.engines.audited import effects_of
from rallygap.pipeline.engines.export.code import CODE, SCENE, ball_effects
from rallygap.pipeline.engines.export.command import check_place, code_of, comments_of, former_scene
from rallygap.pipeline.engines.load import names_function, names_scene
from rallygap.pipeline.gap.expected_balls import expected_balls, expected_json
from rallygap.pipeline.gap.figures import (
    camera_figure,
    causes_figure,
    discrepancy_figure,
    error_figure,
    growth_figure,
)
from rallygap.pipeline.gap.measured_shots import MeasuredShots, read_shots
from rallygap.pipeline.gap.provenance import made_from
from rallygap.pipeline.gap.summary import Findings, detection_lines, episodes_text, usage_lines
from rallygap.pipeline.gap.verdict_page import render_gap_page
from rallygap.pipeline.io.artifacts import replacing_files, write_text
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import check_folder
from rallygap.pipeline.runtime.progress import PhaseBar
from rallygap.pipeline.web.figure_style import apply_style
from rallygap.pipeline.web.report_items import ReportFigure

if TYPE_CHECKING:
    from rallygap.pipeline.engines.export.scene.amended_scene import AmendedScene

TABLE = "table_bounce"
FIGURES = "figures"
FIGURE_NAMES = ("causes", "camera", "discrepancy", "growth", "errors")
FORMER = [CODE, *(f"{FIGURES}/{name}.png" for name in FIGURE_NAMES)]
# Phases of the work with their usual shares of the time, for the progress bar.
PHASES = {"reading and segmenting": 15, "comparing": 75, "writing": 10}
SCENE_PHASES = {"reading and segmenting": 15, "comparing": 60, "writing": 25}


def diagnose_folder(
    data: Path,
    source: str,
    simulator: str,
    level: float,
    out: Path,
    say: Callable[[str], None] = lambda line: None,
    minor: bool = False,
) -> Findings:
    """Diagnose the recordings of a folder and write the verdict.

    ``out`` gets verdict.json, amended.yaml, balls.json, report.html and figures/*.png, all of them
    or none; where the simulator is a function or a scene, the amended one as code; and where it is
    a scene, that amended as well.

    Args:
        data: folder with the files of the source.
        source: name of the adapter that reads them.
        simulator: name of a shipped one, path of a YAML file or of a scene, or a function that
            flies balls.
        level: probability of a false cause where there is no gap.
        out: folder to write to.
        say: called with lines of text: what is used and what is doubtful, then what the shots can
            show, before causes are searched for.
        minor: whether amended.yaml has minor structure as well.

    Raises:
        InputError: any of these cannot be used, or there are too few shots.
    """
    check_folder(out)
    is_scene = names_scene(simulator)
    if is_scene:
        check_place(simulator, out)
    nominal = effects_of(simulator, say)
    settings = GapSettings(level=level)
    with PhaseBar(SCENE_PHASES if is_scene else PHASES) as bar:

        def say_aside(lines: Iterable[str]) -> None:
            with bar.aside():
                for line in lines:
                    say(line)

        with bar.phase("reading and segmenting"):
            measured = read_shots(data, source)
            _check(measured, nominal, data, simulator)
        say_aside(usage_lines(measured))
        with bar.phase("comparing"):
            verdict = diagnose(
                measured.shots,
                nominal,
                settings,
                nets=measured.nets,
                progress=bar.reached,
                on_limits=lambda limits: say_aside(detection_lines(measured, limits)),
            )
        with bar.phase("writing"):
            counts = measured.recordings, len(measured.shots)
            folder = data.resolve().name
            origin = made_from(measured.name, folder, counts, nominal, simulator, level)
            limitations = (*measured.doubts, *verdict.limitations)
            verdict = verdict.model_copy(update={"limitations": limitations, "made_from": origin})
            balls = expected_balls(measured.shots, amended(nominal, verdict, minor))
            findings = Findings(measured, nominal, simulator, settings, verdict, balls, minor)
            if is_scene:
                findings = replace(findings, handed=handed_over(findings))
            write_findings(findings, out)
    return findings


def handed_over(findings: Findings) -> "AmendedScene":
    """Return the scene of a verdict amended, and code for it, both verified.

    A scene that cannot be amended is no error: then there is the code, and a sentence says why.

    Args:
        findings: on a scene of MuJoCo.

    Raises:
        InputError: the scene cannot be read.
    """
    from rallygap.pipeline.engines.export.scene.amended_scene import amended_scene

    name, before = findings.simulator_name, findings.simulator
    comments = comments_of(_amended_yaml(findings))
    after = amended(before, findings.verdict, findings.minor)
    code = ball_effects(after, "amended.yaml", comments, "mujoco")
    return amended_scene(name, before, after, code, comments)


def _amended_yaml(findings: Findings) -> str:
    name = findings.measured.name
    return amended_yaml(findings.simulator, findings.verdict, name, findings.minor)


def write_findings(findings: Findings, out: Path) -> None:
    """Write verdict, amended simulator, expected balls, page and figures, all of them or none.

    Raises:
        InputError: the folder cannot be written to.
    """
    apply_style()
    simulator, figures, handed = _amended_yaml(findings), figures_of(findings), findings.handed
    with replacing_files(out, [*FORMER, *former_scene(out)]) as folder:
        pictures = folder / FIGURES
        pictures.mkdir()
        for figure in figures:
            figure.write(pictures / f"{figure.name}.png")
        write_text(folder / "verdict.json", findings.verdict.to_json())
        write_text(folder / "amended.yaml", simulator)
        write_text(folder / "balls.json", expected_json(findings.balls))
        if names_function(findings.simulator_name):
            write_text(folder / CODE, code_of(str(folder / "amended.yaml"), "python"))
        if handed:
            write_text(folder / CODE, handed.code)
        if handed and handed.text is not None:
            write_text(folder / SCENE, handed.text)
        write_text(folder / "report.html", render_gap_page(findings, simulator, pictures, figures))


def figures_of(findings: Findings) -> list[ReportFigure]:
    """Return the figures for which the verdict has content."""
    verdict = findings.verdict
    figures, located = [], verdict.located
    if verdict.main_causes:
        figures.append(causes_figure(verdict))
    if verdict.camera:
        shots = findings.measured.shots
        figures.append(camera_figure(verdict, shots.positions[shots.valid]))
    if located and located.discrepancy.any():
        figures.append(discrepancy_figure(located))
    if located and located.growth:
        figures.append(growth_figure(located))
    if verdict.gap:
        figures.append(error_figure(verdict.gap))
    return figures


def _check(measured: MeasuredShots, nominal: Simulator, data: Path, simulator: str) -> None:
    """Raise unless there are enough shots, and a table where they bounce."""
    count, least = len(measured.shots), DEFAULTS.verify.held_out
    if count < least:
        problem = (
            f"{count} of its {measured.episodes} episodes are unbroken shots of more than twelve "
            f"samples; give at least {least}, in the table's frame, in m and s (used: "
            f"{episodes_text(measured)})"
        )
        raise InputError(data, problem)
    if measured.bounces and TABLE not in nominal.effects:
        problem = (
            f"is missing, but {measured.bounces} of the shots bounce; add such as "
            f"{TABLE}: {{restitution: 0.93, friction: 0.25}}"
        )
        raise InputError(simulator, problem, field=TABLE)
