"""Keep the results of a DVC experiment in the repository, with what it takes to reproduce them."""

import shlex
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from models.support.yaml_file import parse_yaml
from pipeline.experiments.profiles import flags
from pipeline.io.artifacts import replacing_folder, write_json, write_text
from pipeline.io.report_manifest import read_contents
from pipeline.runtime.console import warn
from pipeline.runtime.errors import InputError
from pipeline.runtime.scratch import kept_timings

PREDICTORS = "artifacts/train_predictor"
RECORD = "run.json"
LARGEST_FILE = 30_000_000  # bytes; larger ones would stay in git's history


def keep_experiment(root: Path, name: str) -> None:
    """Copy the reports of the newest experiment of a name into ``reports/<name>``.

    Its trained predictors come with them, into ``predictors/``, but none that is too large for
    git. ``run.json`` names the commit, the command, the parameters and each stage's fingerprint.
    Nothing in it comes from this machine: the folder of the measured sets is a setting of the
    environment. Where this machine ran it, ``timings.json`` has how long that took.

    Raises:
        InputError: there is no such experiment, its parameters name a folder of this machine, a
            file of it is not to be had, or reports has another folder of that name.
    """
    revision, baseline = find_experiment(root, name)
    params = _params_at(root, revision)
    if Path(params.get("ingest", {}).get("folder") or "").is_absolute():
        problem = "names a folder of this machine; run it again with RALLYGAP_DATA in its place"
        raise InputError(f"experiment {name}", problem, field="ingest.folder")
    with _complete(name), replacing_folder(root / "reports" / name) as folder:
        stages = _copy_reports(root, revision, folder)
        _copy_predictors(root, revision, folder / "predictors", f"reports/{name}")
        command = ["dvc", "exp", "run", *flags(_params_at(root, baseline), params)]
        record = {
            "experiment": name,
            "commit": baseline,
            "command": shlex.join(command),
            "fingerprints": {stage: read_contents(folder, stage).fingerprint for stage in stages},
            "params": params,
        }
        write_json(folder / RECORD, record)
        _write_timings(root, baseline, [folder / stage for stage in stages])


@contextmanager
def _complete(name: str) -> Iterator[None]:
    """Refuse an experiment of which DVC cannot find a file."""
    try:
        yield
    except FileNotFoundError as error:
        problem = f"neither this machine nor a remote has {error.filename}; `dvc exp pull` may"
        raise InputError(f"experiment {name}", problem) from None


def find_experiment(root: Path, name: str) -> tuple[str, str]:
    """The commit of the newest experiment of a name, and the commit it started from.

    Raises:
        InputError: there is none.
    """
    # refs/exps/<2 digits>/<38 digits of the commit it started from>/<name>
    pattern = "refs/exps/*/*/*"
    listed = _git(
        root,
        ["for-each-ref", "--sort=-committerdate", "--format=%(objectname) %(refname)", pattern],
    )
    for line in listed.splitlines():
        revision, reference = line.split()
        _, _, start, rest, found = reference.split("/")
        if found == name:
            return revision, start + rest
    problem = "there is no such experiment; `dvc exp list --all-commits` names them"
    raise InputError("dvc", problem, field=name)


def _copy_reports(root: Path, revision: str, folder: Path) -> list[str]:
    """Copy the report of every stage of a revision, and the page; return the stages."""
    from dvc.api import DVCFileSystem

    files = DVCFileSystem(str(root), rev=revision)
    stages = list(parse_yaml(files.read_text("dvc.yaml"))["stages"])
    _check_name(root, folder.name, stages)
    for stage in stages:
        files.get(f"reports/{stage}", str(folder / stage), recursive=True)
    files.get_file("reports/index.html", str(folder / "index.html"))
    return stages


def _check_name(root: Path, name: str, stages: Sequence[str]) -> None:
    """Refuse a name under which reports has, or will have, anything but a kept experiment."""
    path = root / "reports" / name
    if name in stages:
        problem = f"has the name of a stage, whose results are in reports/{name}; rename it"
        raise InputError(f"experiment {name}", problem)
    if path.exists() and not (path / RECORD).is_file():
        problem = f"would take the place of reports/{name}, which is no kept experiment; rename it"
        raise InputError(f"experiment {name}", problem)


def _copy_predictors(root: Path, revision: str, folder: Path, reports: str) -> None:
    """Copy the trained predictors of a revision; their cards then name ``reports`` of their own."""
    from dvc.api import DVCFileSystem

    from pipeline.predictors.storage import CARD, WEIGHTS

    files = DVCFileSystem(str(root), rev=revision)
    if files.exists(PREDICTORS):
        files.get(PREDICTORS, str(folder), recursive=True)
    for weights in list(folder.rglob(WEIGHTS)):
        if weights.stat().st_size > LARGEST_FILE:
            shutil.rmtree(weights.parent)
            warn(f"{weights.parent.name} is left out: its weights are too large for git")
    for card in folder.rglob(CARD):
        write_text(card, card.read_text(encoding="utf-8").replace("`reports/", f"`{reports}/"))


def _write_timings(root: Path, commit: str, reports: Sequence[Path]) -> None:
    """Write how long things took, and on what machine, where it was this one."""
    timings = {report.name: kept_timings(root, report) for report in reports}
    known = {stage: seconds for stage, seconds in timings.items() if seconds}
    if known:
        from pipeline.evaluation.costs import machine  # takes seconds

        ran = {**machine(root), "commit": commit}
        write_json(reports[0].parent / "timings.json", {"machine": ran, **known})


def _params_at(root: Path, revision: str) -> Any:
    return parse_yaml(_git(root, ["show", f"{revision}:params.yaml"]))


def _git(root: Path, arguments: list[str]) -> str:
    command = ["git", *arguments]
    try:
        return subprocess.run(command, cwd=root, capture_output=True, text=True, check=True).stdout
    except subprocess.CalledProcessError as error:
        raise InputError(root, " ".join(error.stderr.split())) from None
