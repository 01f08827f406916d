"""The ``rallygap`` command. Its functions import what they need when they are called."""

import os
import socket
import sys
from pathlib import Path
from typing import Annotated

import typer

from rallygap.pipeline.benchmark.command import app as benchmark
from rallygap.pipeline.runtime.console import refuse, show
from rallygap.pipeline.runtime.determinism import hold_arithmetic
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.extras import missing_extra, require
from rallygap.pipeline.runtime.guard import disks_named
from rallygap.pipeline.runtime.paths import clone

ANY_SIMULATOR = "a shipped one's name, a YAML file, scene.xml, or file.py:function"

GAP, RUNS = "The gap", "Runs of the pipeline"  # headings of `rallygap --help`

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)


def main() -> None:
    """Run the command line.

    A user's input error, a full disk and a missing optional package are one line and status 2.
    """
    hold_arithmetic()
    try:
        with disks_named("output"):
            app()
    except InputError as error:
        try:
            sys.stdout.flush()
        except OSError:  # dropped, what a full disk refuses: Python would write it when it ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        refuse(error)
    except ModuleNotFoundError as error:
        refuse(_not_installed(error))


def _not_installed(error: ModuleNotFoundError) -> InputError:
    """Return which extra brings the package that is missing; raise the error if none does."""
    package = (error.name or "").partition(".")[0]
    extra = missing_extra(package)
    if extra is None:
        raise error
    problem = f"is not installed; this command needs the extra: pip install 'rallygap[{extra}]'"
    if extra == "pipeline" and sys.version_info >= (3, 12):
        problem += " in Python 3.11, since PyBullet has no wheels for later ones"
    return InputError(package, problem)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"rallygap {version('rallygap')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool,
        typer.Option("--version", is_eager=True, callback=_print_version, help="print the version"),
    ] = False,
) -> None:
    """Find where a table-tennis simulation and measured trajectories disagree."""


@app.command(rich_help_panel=GAP)
def diagnose(
    data: Annotated[Path, typer.Argument(help="the folder of the recordings")],
    simulator: Annotated[str, typer.Option(help=ANY_SIMULATOR)],
    out: Annotated[Path, typer.Option(help="the folder to write to")],
    source: Annotated[str, typer.Option(help="the adapter that reads the recordings")] = "csv",
    level: Annotated[
        float, typer.Option(min=1e-4, max=0.5, help="probability of a false cause without a gap")
    ] = 0.003,
    everything: Annotated[
        bool,
        typer.Option(
            "--all", help="amend minor structure as well as leading causes and sensor faults"
        ),
    ] = False,
) -> None:
    """Say where recordings and a simulator disagree, why, and by how much."""
    from rallygap.pipeline.gap.diagnose_folder import diagnose_folder

    findings = diagnose_folder(data, source, simulator, level, out, typer.echo, everything)
    typer.echo()
    limitations = [f"Limitation: {limitation}." for limitation in findings.verdict.limitations]
    for line in (*findings.outcome, *findings.details, *limitations):
        typer.echo(line)
    typer.echo(f"Report: {out / 'report.html'}")


@app.command(rich_help_panel=GAP)
def audit(
    simulator: Annotated[str, typer.Argument(help=ANY_SIMULATOR)],
    out: Annotated[Path, typer.Option(help="the folder to write to")],
    against: Annotated[
        str | None, typer.Option(help="another simulator to compare it with")
    ] = None,
) -> None:
    """Say which effects a simulator really has, by probe shots; no measurements are needed."""
    from rallygap.pipeline.engines.audit_folder import audit_folder

    for line in audit_folder(simulator, out, against):
        typer.echo(line)
    typer.echo(f"Report: {out / 'report.html'}")


@app.command(rich_help_panel=GAP)
def export(
    simulator: Annotated[str, typer.Argument(help="a shipped one's name, or a YAML file")],
    to: Annotated[str, typer.Option(help="python, pybullet or mujoco")],
    out: Annotated[
        Path | None, typer.Option(help="the file to write; with --scene, the folder")
    ] = None,
    scene: Annotated[
        str | None, typer.Option(help="scene.xml of MuJoCo, to be amended and verified too")
    ] = None,
) -> None:
    """Write a simulator's flight and bounce for another engine: as code, or as a scene as well."""
    from rallygap.pipeline.engines.export.code import CODE
    from rallygap.pipeline.engines.export.command import export, export_scene

    if scene is None:
        out = out or Path(CODE)
        export(simulator, to, out)
    else:
        out = out or Path("amended")
        for line in export_scene(simulator, to, scene, out):
            typer.echo(line)
    typer.echo(f"Written: {out}")


@app.command(rich_help_panel=GAP)
def simulators() -> None:
    """List the shipped simulators: their names, and their effects as YAML."""
    from textwrap import indent

    from rallygap.models.ball.simulators import shipped_names, shipped_text

    typer.echo("\n".join(f"{name}\n{indent(shipped_text(name), '  ')}" for name in shipped_names()))


@app.command(rich_help_panel=GAP)
def example(folder: Annotated[Path, typer.Argument(help="a new folder")]) -> None:
    """Write recordings of 30 shots into FOLDER, to try `diagnose` and `live` on."""
    from rallygap.pipeline.io.example import write_example

    write_example(folder)
    typer.echo(f"Try: rallygap diagnose {folder} --simulator literature --out verdict")


@app.command(rich_help_panel=RUNS)
def check() -> None:
    """Check params.yaml, without running anything."""
    from rallygap.pipeline.params import load_params

    path = clone() / "params.yaml"
    load_params(path)
    typer.echo(f"{path} is in order.")


@app.command(rich_help_panel=RUNS)
def profile(
    name: Annotated[str, typer.Argument(help="a file of the folder experiments/profiles")],
) -> None:
    """Print a profile as flags, for `dvc exp run $(rallygap profile smoke)`."""
    from rallygap.pipeline.profiles import profile_flags

    typer.echo(" ".join(profile_flags(clone(), name)))


@app.command(rich_help_panel=RUNS)
def ui(
    port: Annotated[int, typer.Option(min=1, max=65535, help="on this machine only")] = 5000,
) -> None:
    """Serve the MLflow pages of this repository's runs, until interrupted."""
    from rallygap.pipeline.tracking.runs import EXPERIMENT, store_uri

    require("mlflow")
    root = clone()
    try:  # MLflow would say so in many lines, and with status 0
        socket.create_server(("127.0.0.1", port)).close()
    except OSError as error:
        problem = f"{port} cannot be had: {os.strerror(error.errno or 0)}; give another one"
        raise InputError("--port", problem) from None
    address = f"http://127.0.0.1:{port}/#/experiments"
    typer.echo(f"Runs: {address}, experiment {EXPERIMENT} (Ctrl+C ends the server)")
    sys.stdout.flush()  # MLflow takes the place of this process
    os.environ["MLFLOW_SERVER_ENABLE_JOB_EXECUTION"] = "false"  # nobody submits jobs
    command = ["mlflow", "server", "--host", "127.0.0.1", "--port", str(port), "--workers", "1"]
    store = ["--backend-store-uri", store_uri(root)]
    # So what stops this process stops the server.
    os.execv(sys.executable, [sys.executable, "-m", *command, *store])


@app.command(rich_help_panel=RUNS)
def sweep(
    name: Annotated[
        str, typer.Argument(help="a file in experiments/profiles/sweeps, such as quick")
    ],
    study: Annotated[
        str | None, typer.Option(envvar="RALLYGAP_STUDY", help="URL of a database; default: a file")
    ] = None,
    trials: Annotated[
        int | None, typer.Option(min=1, help="total, with those of earlier runs")
    ] = None,
) -> None:
    """Search hyperparameters with Optuna; more workers are more processes of this command."""
    from rallygap.pipeline.sweeps.settings import Sweep
    from rallygap.pipeline.sweeps.study import run_sweep

    loaded = Sweep(clone(), name)
    best = run_sweep(loaded, study, trials or loaded.settings.trials)
    typer.echo(f"Report: {loaded.report}")
    typer.echo(" ".join(["dvc exp run", *best]) if best else "No trial is better than params.yaml.")


@app.command(rich_help_panel=RUNS)
def confirm(
    name: Annotated[str, typer.Argument(help="a sweep that was run, such as predictor")],
) -> None:
    """Train with the best parameters of a sweep and params.yaml; compare on unseen shots."""
    from rallygap.pipeline.sweeps.confirm import confirmed_table, run_confirm
    from rallygap.pipeline.sweeps.settings import Sweep

    loaded = Sweep(clone(), name)
    table = run_confirm(loaded)
    if table is None:
        typer.echo("params.yaml has the best parameters of the sweep: there is nothing to confirm.")
        return
    show(confirmed_table(table))
    typer.echo(f"Report: {loaded.report}")


app.add_typer(benchmark, name="benchmark", rich_help_panel=RUNS)


@app.command(rich_help_panel=GAP)
def live(
    simulator: Annotated[str, typer.Option(help="a shipped one's name, or a YAML file")],
    predictor: Annotated[
        Path | None, typer.Option(help="the folder of a trained one that forecasts instead")
    ] = None,
    balls: Annotated[
        Path | None, typer.Option(help="the balls.json of a verdict, the balls to expect")
    ] = None,
    observations: Annotated[
        str, typer.Option(help="address of the camera server, JSON by ZeroMQ")
    ] = "tcp://127.0.0.1:7660",
    forecasts: Annotated[
        str, typer.Option(help="address to publish forecasts at")
    ] = "tcp://127.0.0.1:7661",
    recordings: Annotated[
        Path | None, typer.Option("--replay", help="a folder of recordings, instead of a server")
    ] = None,
    source: Annotated[str, typer.Option(help="the adapter that reads the recordings")] = "csv",
    speed: Annotated[
        float, typer.Option(min=0.01, max=1000, help="of the replay; 1 is as recorded")
    ] = 1.0,
    view: Annotated[
        bool, typer.Option("--view", help="show the ball and its forecast in the browser")
    ] = False,
    view_port: Annotated[int, typer.Option(help="of the view, on this machine only")] = 7662,
) -> None:
    """Forecast the ball while it is measured; Ctrl-C ends with a histogram of latencies."""
    from rallygap.pipeline.live.command import forecaster, replay, serve
    from rallygap.pipeline.live.latency import summary

    ready = forecaster(simulator, predictor, balls)
    port = view_port if view else None
    if recordings is None:
        typer.echo(f"Measurements from {observations}, forecasts at {forecasts}.")
        latencies = serve(ready, observations, forecasts, port)
    else:
        latencies = replay(ready, recordings, source, speed, forecasts, port)
    for line in [summary(latencies), *latencies.histogram()]:
        typer.echo(line)
