"""Diagnose a folder of recordings: read, cut, compare with a simulator, write the verdict down."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from models.ball.simulator import Simulator
from models.gap.amend.simulator import amended_yaml
from models.gap.diagnose import HELD_OUT, Sight, diagnose
from models.gap.verdict import Verdict
from pipeline.gap.figures.discrepancy import growth_figure, parting_figure
from pipeline.gap.figures.verdict import causes_figure, error_figure
from pipeline.gap.measured_shots import MeasuredShots, read_shots
from pipeline.gap.summary import Findings, sight_lines
from pipeline.gap.verdict_page import Illustration, render_gap_page
from pipeline.io.artifacts import write_text
from pipeline.io.figure_style import apply_style, save_figure
from pipeline.io.simulators import load_simulator
from pipeline.runtime.errors import InputError
from pipeline.runtime.paths import check_folder
from pipeline.runtime.progress import phase_bar

TABLE = "table_bounce"
FIGURES = "figures"
ILLUSTRATIONS = {
    "causes": Illustration(
        "causes",
        "How far from the simulator",
        "Every cause's estimate with its 95 % interval, in the smallest size that these shots show "
        "almost surely beside the other causes; less, in the pale band, might stay hidden.",
    ),
    "parting": Illustration(
        "parting",
        "How simulated and measured balls part",
        "Both start alike at the twelfth sample; noise and scatter are left out. Left: the bands "
        "are what vanishes when flight, table or measurement is replaced by the measured one; a "
        "phase's share is its band's part of the area. Right: the mean of all shots along the "
        "ball's course, across it (to the right) and up, with 95 % intervals.",
    ),
    "growth": Illustration(
        "growth",
        "Against what it grows",
        "What every shot says of its own parting, no law assumed: means of bins with 95 % "
        "intervals, against the axes that tell most. Above: the part of the shots' variance that "
        "goes with the axis, and the chance that any axis tells as much where none does; pale "
        "where it is above 5 %. Axes that go together, such as place and direction, tell the same.",
    ),
    "errors": Illustration(
        "errors",
        "Prediction error over the horizon",
        "Of shots that naming never saw, each predicted from its first twelve samples: with the "
        "simulator as it was, amended, and without any gap. Bands: 95 %, bootstrapped over shots.",
    ),
}
# Phases and their usual shares of the time, by which the bar tells what is left.
PHASES = {"reading and cutting": 15, "comparing": 75, "writing": 10}


def diagnose_folder(
    data: Path,
    source: str,
    simulator: str,
    level: float,
    out: Path,
    say: Callable[[str], None] = lambda line: None,
) -> Findings:
    """Diagnose the recordings of a folder and write what was found.

    ``out`` gets verdict.json, amended.yaml, report.html and figures/*.png, all of them or none.

    Args:
        data: folder with the files of the source.
        source: name of the adapter that reads them.
        simulator: name of a shipped one, or path of a YAML file.
        level: chance of a false name where there is no gap.
        out: folder to write to.
        say: is told what the shots can show, line by line, before causes are looked for.

    Raises:
        InputError: any of these cannot be used, or there are too few shots.
    """
    check_folder(out)
    compared = load_simulator(simulator)
    with phase_bar(PHASES) as bar:
        with bar.phase("reading and cutting"):
            measured = read_shots(data, source)
            _check_enough(measured, data)
            _check_table(measured, compared, simulator)

        def shown(sight: Sight) -> None:
            with bar.aside():
                for line in sight_lines(measured, compared, sight):
                    say(line)

        with bar.phase("comparing"):
            verdict = diagnose(measured.shots, compared, level, progress=bar.reached, sight=shown)
        findings = Findings(measured, compared, simulator, level, verdict)
        with bar.phase("writing"):
            write_findings(findings, out)
    return findings


def write_findings(findings: Findings, out: Path) -> None:
    """Write verdict, amended simulator, page and figures, all of them or none.

    Raises:
        InputError: the folder cannot be written to.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out, prefix=".rallygap.") as name:
            _write_all(findings, Path(name))
            _replace_all(Path(name), out)
    except OSError as error:
        raise InputError(out, f"cannot be written to: {error.strerror}") from None


def figures_of(verdict: Verdict) -> dict[str, Figure]:
    """Return the figures that a verdict has something for, by name."""
    figures = {}
    if verdict.effects:
        figures["causes"] = causes_figure(verdict)
    if verdict.located and verdict.located.discrepancy.any():
        figures["parting"] = parting_figure(verdict.located)
    if verdict.located and verdict.located.growth:
        figures["growth"] = growth_figure(verdict.located)
    if verdict.gap:
        figures["errors"] = error_figure(verdict.gap)
    return figures


def _write_all(findings: Findings, folder: Path) -> None:
    amended = amended_yaml(findings.simulator, findings.verdict, findings.measured.name)
    pictures = folder / FIGURES
    pictures.mkdir()
    apply_style()
    figures = figures_of(findings.verdict)
    for name, figure in figures.items():
        save_figure(pictures / f"{name}.png", figure)
    shown = [ILLUSTRATIONS[name] for name in figures]
    write_text(folder / "verdict.json", findings.verdict.to_json())
    write_text(folder / "amended.yaml", amended)
    write_text(folder / "report.html", render_gap_page(findings, amended, pictures, shown))


def _replace_all(folder: Path, out: Path) -> None:
    """Move all files to where they belong; figures of an earlier verdict go, all else stays."""
    (out / FIGURES).mkdir(exist_ok=True)
    for name in ILLUSTRATIONS:
        (out / FIGURES / f"{name}.png").unlink(missing_ok=True)
    for path in sorted(folder.rglob("*.*")):
        path.replace(out / path.relative_to(folder))


def _check_enough(measured: MeasuredShots, data: Path) -> None:
    count = len(measured.shots)
    if count < HELD_OUT:
        problem = (
            f"{count} of its {measured.episodes} episodes are unbroken shots of more than twelve "
            f"samples; give at least {HELD_OUT}, in the table's frame, in m and s"
        )
        raise InputError(data, problem)


def _check_table(measured: MeasuredShots, compared: Simulator, simulator: str) -> None:
    if measured.bounces and TABLE not in compared.effects:
        problem = (
            f"is missing, but {measured.bounces} of the shots bounce; add such as "
            f"{TABLE}: {{restitution: 0.93, friction: 0.25}}"
        )
        raise InputError(simulator, problem, field=TABLE)
