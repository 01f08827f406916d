"""The whole pipeline with the parameters of a profile, in a copy of the repository.

``python -m experiments.stages.profile shots`` runs it with ``experiments/profiles/shots.yaml``.
Tables and parameters go to ``reports/shots``, trained predictors to ``artifacts/profiles/shots``.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

from rallygap.pipeline.io.artifacts import write_json, write_text
from rallygap.pipeline.profiles import profile_params
from rallygap.pipeline.report.stages import PIPELINE
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.git import git

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
    copy = _copied(root, root / "scratch" / "profile" / name)
    write_text(copy / "params.yaml", str(yaml.safe_dump(params, sort_keys=False)))
    environment = {key: value for key, value in os.environ.items() if not key.startswith("DVC_")}
    command = [sys.executable, "-m", "dvc", "repro"]
    if subprocess.run(command, cwd=copy, env=environment, check=False).returncode:
        raise InputError(f"profile {name}", "has failed; run it again, finished stages are kept")
    for stage in PIPELINE:
        for table in (copy / "reports" / stage).glob("*.csv"):
            _copy(table, root / "reports" / name / stage / table.name)
    for stage in SHOWN.get(name, ()):
        for figure in (copy / "reports" / stage / "figures").glob("*.png"):
            _copy(figure, root / "reports" / name / stage / "figures" / figure.name)
    write_json(root / "reports" / name / "params.json", params)
    trained = root / "artifacts" / "profiles" / name / "train_predictor"
    shutil.copytree(copy / "artifacts" / "train_predictor", trained, dirs_exist_ok=True)


def _copied(root: Path, folder: Path) -> Path:
    """Copy what git knows of a repository, outside git but with the same DVC cache."""
    listed = git(root, "ls-files", "-z", "--cached", "--others", "--exclude-standard")
    if listed is None:
        raise InputError(root, "is no repository of git")
    for name in listed.split("\0"):
        source = root / name
        if name and not name.startswith("dvc.lock") and (source.is_symlink() or source.is_file()):
            _copy(source, folder / name)
    cache = (root / ".dvc" / "cache").resolve()
    settings = f"[core]\n    no_scm = true\n[cache]\n    dir = {cache}\n"
    write_text(folder / ".dvc" / "config.local", settings)
    return folder


def _copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    if not target.is_symlink():
        shutil.copy(source, target, follow_symlinks=False)


if __name__ == "__main__":
    try:
        profile(Path.cwd(), sys.argv[1])
    except InputError as error:
        refuse(error)
