"""The whole pipeline with the parameters of a profile, in a copy of the repository.

``python -m experiments.stages.profile shots`` runs it with ``experiments/profiles/shots.yaml``.
Tables and parameters go to ``reports/shots``, trained predictors to ``artifacts/profiles/shots``.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import typer
import yaml

from experiments.clone import copy_sources, environment
from rallygap.pipeline.io.artifacts import write_json, write_text
from rallygap.pipeline.profiles import profile_params
from rallygap.pipeline.report.stages import PIPELINE
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError

# Figures that documentation pages show, by profile: of these stages.
SHOWN = {"real": ["close_gap"], "shots": ["shot_quality", "train_policy"]}


def profile(root: Path, name: str) -> None:
    """Run the pipeline with a profile in ``scratch/profile/NAME``, and copy what it reports.

    The runs of its stages are those of the copy, so this has none of its own.

    Args:
        root: the repository.
        name: of the profile.

    Raises:
        InputError: there is no such profile, or a stage fails.
    """
    params = profile_params(root, name).model_dump(mode="json")
    copy = root / "scratch" / "profile" / name
    copy_sources(root, copy)
    # Outside git, but with the same DVC cache.
    cache = (root / ".dvc" / "cache").resolve()
    settings = f"[core]\n    no_scm = true\n[cache]\n    dir = {cache}\n"
    write_text(copy / ".dvc" / "config.local", settings)
    write_text(copy / "params.yaml", str(yaml.safe_dump(params, sort_keys=False)))
    command = [sys.executable, "-m", "dvc", "repro"]
    if subprocess.run(command, cwd=copy, env=environment(copy), check=False).returncode:
        raise InputError(f"profile {name}", "has failed; run it again, finished stages are kept")
    reports = copy / "reports"
    shown = [path for stage in PIPELINE for path in (reports / stage).glob("*.csv")]
    shown += [
        path for stage in SHOWN.get(name, ()) for path in reports.glob(f"{stage}/figures/*.png")
    ]
    for path in shown:
        target = root / "reports" / name / path.relative_to(reports)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, target)
    write_json(root / "reports" / name / "params.json", params)
    trained = root / "artifacts" / "profiles" / name / "train_predictor"
    shutil.copytree(copy / "artifacts" / "train_predictor", trained, dirs_exist_ok=True)


def main(name: str) -> None:
    """Run the pipeline with the profile NAME."""
    try:
        profile(Path.cwd(), name)
    except InputError as error:
        refuse(error)


if __name__ == "__main__":
    typer.run(main)
