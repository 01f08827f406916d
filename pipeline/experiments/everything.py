"""``make everything``: all results that the repository keeps, made by one commit.

A step is done if neither its parameters nor the packages that it imports have changed since the
commit that ``reports/commits.json`` has for it; packages that only present results do not count. A
killed run goes on where it was: steps that are done are passed over, and the long ones resume.
"""

import os
import shlex
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from rallygap.pipeline.experiments.keep import has_experiment
from rallygap.pipeline.experiments.profiles import profile_flags
from rallygap.pipeline.experiments.stale import (
    KeptResult,
    check_committed,
    code_of,
    kept_modules,
    result_of,
    stage_modules,
)
from rallygap.pipeline.io.artifacts import read_json, write_json
from rallygap.pipeline.runtime.errors import InputError

PARAMS = "params.yaml"
COMMITS = Path("reports") / "commits.json"  # of the code that made each step's results
DURATIONS = Path("timings") / "everything.json"  # s, on this machine
PYTHON = "python -m"
OF_PREDICTORS = ("segment", "train_predictor", "close_gap")  # stages
BENCHMARKS = {  # minutes
    "ball_simulator": 1,
    "policy_training": 1,
    "learning": 19,
    "live": 7,
    "drift": 11,
    "scale": 7,
    "precision": 8,
}


@dataclass(frozen=True)
class Step:
    """Some of the results.

    Attributes:
        name: of the step.
        commands: that make them, in this order.
        minutes: that they took on two cores.
        entries: modules that make the results, and stages whose outputs these read; all stages if
            there are none.
        profile: that the results depend on, below ``profiles``.
        files: other paths that the results depend on.
        experiment: whether an experiment of DVC with the profile comes before the commands.
        measured: whether they need the measured sets.
        root: whether they need a user who may fill disks.
        gpu: whether they need a GPU.
    """

    name: str
    commands: tuple[str, ...]
    minutes: int
    entries: tuple[str, ...] = ()
    profile: str = ""
    files: tuple[str, ...] = ()
    experiment: bool = False
    measured: bool = False
    root: bool = False
    gpu: bool = False


def _kept(profile: str, name: str, minutes: int) -> Step:
    """Return the step that runs and keeps an experiment."""
    return Step(name, (f"rallygap keep {name}",), minutes, profile=profile, experiment=True)


def _module(
    name: str, minutes: int, stages: Sequence[str] = (), profile: str = "", measured: bool = False
) -> Step:
    """Return the step that runs a module of ``pipeline``, which reads what some stages made."""
    module = f"rallygap.pipeline.{name}"
    step = name.removesuffix(".run").replace(".", "_")
    entries = (module, *(f"rallygap.stages.{one}" for one in stages))
    command = f"{PYTHON} {module}"
    return Step(step, (command,), minutes, entries, profile, measured=measured)


STEPS = (
    Step("reproduce", ("dvc repro",), 18),
    _module("learning_curves.run", 100, ["segment"]),
    _module("spread_policies.run", 15, OF_PREDICTORS),
    _module("swap_study.run", 130, OF_PREDICTORS, "policies"),
    _module("arenas.run", 150),
    _module("simulator_scenes.run", 10),
    _module("simulator_scenes.real", 12, measured=True),
    Step("real", ("rallygap real",), 70, profile="real", measured=True),
    _module("real_forecasts.run", 25, ["train_predictor"], measured=True),
    Step(
        "known_answers",
        ("rallygap known-answers",),
        45,
        ("rallygap.pipeline.known_answers.run",),
        measured=True,
    ),
    _kept("two_cores", "paper", 150),
    replace(_module("paper_network.run", 15, profile="paper"), gpu=True),
    _kept("paper_physics", "paper_physics", 30),
    _kept("shots", "shots", 160),
    Step(
        "exam",
        (f"{PYTHON} rallygap.pipeline.exam.full_run", "dvc repro"),
        165,
        ("rallygap.pipeline.exam.full_run",),
    ),
    Step(
        "sweeps",
        tuple(
            f"rallygap {verb} {name}"
            for name in ("predictor", "policy")
            for verb in ("sweep", "confirm")
        ),
        20,
        ("rallygap.pipeline.sweeps.worker", "rallygap.pipeline.sweeps.confirm"),
        "sweeps",
    ),
    Step(
        "reliability",
        ("pytest -m faults -v --tables",),
        53,
        files=("tests/faults", "tests/fuzz"),
        root=True,
    ),
    Step(
        "costs",
        ("rallygap costs",),
        20,
        ("rallygap.pipeline.evaluation.costs", "rallygap.stages.train_predictor"),
    ),
    *(
        Step(
            f"{name}_benchmark", (f"{PYTHON} benchmarks.{name}",), minutes, (f"benchmarks.{name}",)
        )
        for name, minutes in BENCHMARKS.items()
    ),
    Step("reproduce_benchmark", (f"{PYTHON} benchmarks.reproduce",), 20),
)


def step_results(root: Path) -> list[KeptResult]:
    """Return the age of the results of every step."""
    commits = _noted(root / COMMITS)
    return [
        result_of(root, root / one.name, commits.get(one.name, ""), _code(root, one))
        for one in STEPS
    ]


def _code(root: Path, step: Step) -> tuple[str, ...]:
    """Return what the results of a step depend on."""
    modules = kept_modules(root) if step.profile else stage_modules(root)
    profile = [f"profiles/{step.profile}.yaml", f"profiles/{step.profile}"] if step.profile else []
    return code_of(step.entries or modules, [PARAMS, *profile, *step.files])


def make_everything(root: Path, names: Sequence[str] = ()) -> None:
    """Make the results of all steps that are older than the code, or of some steps.

    Raises:
        InputError: there is no such step, code is not committed, or a command fails.
    """
    known = [one.name for one in STEPS]
    for name in names:
        if name not in known:
            raise InputError("everything", f"there are {', '.join(known)}", field=name)
    stale = {one.folder.name for one in step_results(root) if one.is_stale}
    due = [one for one in STEPS if one.name in (names or stale)]
    possible = [one for one in due if not _missing(one)]
    for number, step in enumerate(possible, start=1):
        left = sum(_seconds(root, one) for one in possible[number - 1 :])
        _say(f"{step.name}: step {number} of {len(possible)}, {_duration(left)} left")
        _make(root, step)
    for one in due:
        if reason := _missing(one):
            _say(f"{one.name}: {reason}")


def _make(root: Path, step: Step) -> None:
    commit, start = check_committed(root), time.monotonic()
    if commit is None:
        raise InputError(root, "is no clone of the repository; results name a commit")
    # DVC refuses to run an experiment again that a killed step has made.
    if step.experiment and not has_experiment(root, step.name, commit):
        run = ["dvc", "exp", "run", "--temp", "--name", step.name]
        _run(root, [*run, *profile_flags(root, step.profile)])
    for command in step.commands:
        _run(root, shlex.split(command))
    for path, value in ((COMMITS, commit), (DURATIONS, round(time.monotonic() - start))):
        write_json(root / path, {**_noted(root / path), step.name: value})


def _run(root: Path, words: Sequence[str]) -> None:
    """Run a command in the repository.

    Raises:
        InputError: it fails.
    """
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = {**os.environ, "PATH": path}  # the programs of this installation
    if subprocess.run(words, cwd=root, env=environment, check=False).returncode:
        problem = "has failed; once that is fixed, `make everything` goes on"
        raise InputError(shlex.join(words), problem)


def _missing(step: Step) -> str:
    """Return what a step needs and this machine lacks."""
    if step.measured and not Path(os.environ.get("RALLYGAP_DATA") or "missing").is_dir():
        return "left out, because it needs the measured sets: make everything DATA=~/sets"
    if step.root and os.geteuid() != 0:
        return "left out, because only root can fill disks"
    if step.gpu and not _has_gpu():
        return "left out, because torch finds no GPU here"
    return ""


def _has_gpu() -> bool:
    import torch

    return torch.cuda.is_available()


def _seconds(root: Path, step: Step) -> float:
    return float(_noted(root / DURATIONS).get(step.name, 60 * step.minutes))


def _noted(path: Path) -> dict[str, Any]:
    """Return what earlier runs have noted, by step."""
    return dict(read_json(path)) if path.is_file() else {}


def _duration(seconds: float) -> str:
    minutes = round(seconds / 60)
    return f"{minutes // 60} h {minutes % 60:02} min" if minutes >= 60 else f"{minutes} min"


def _say(text: str) -> None:
    Console(highlight=False).print(text)
