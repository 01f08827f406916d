"""Keep the results of a DVC experiment in the repository, with what it takes to reproduce them."""

import shlex
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rallygap.models.support.yaml_file import parse_yaml
from rallygap.pipeline.experiments.profiles import flags
from rallygap.pipeline.experiments.stale import EXAM
from rallygap.pipeline.io.artifacts import replacing_folder, write_json, write_text
from rallygap.pipeline.io.report_manifest import read_contents
from rallygap.pipeline.paper.run_reports import RECORD, is_kept_run
from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.git import git, git_if_known

PREDICTORS = "artifacts/train_predictor"
OF_PREDICTORS = ("seed", "ingest", "segment", "train_predictor")  # parameters
LARGEST_FILE = 30_000_000  # bytes; larger ones would stay in git's history


def keep_experiment(root: Path, name: str) -> None:
    """Copy the reports of the newest experiment of a name into ``reports/<name>``, but the exam's.

    Its trained predictors come with them, into ``predictors/``, unless those of ``dvc repro`` are
    the same, and none that is too large for git. Files that other commands wrote into
    ``reports/<name>`` stay, such as the known answers. ``run.json`` names the commit, the command,
    the parameters and each stage's fingerprint. Nothing in it comes from this machine: the folder
    of the measured sets is a setting of the environment.

    Raises:
        InputError: there is no such experiment, its parameters name a folder of this machine, a
            file of it is not to be had, or reports has another folder of that name.
    """
    revision, baseline = _find_experiment(root, name)
    params, usual = _params_at(root, revision), _params_at(root, baseline)
    if Path(params.get("ingest", {}).get("folder") or "").is_absolute():
        problem = "names a folder of this machine; run it again with RALLYGAP_DATA in its place"
        raise InputError(f"experiment {name}", problem, field="ingest.folder")
    try:
        with replacing_folder(root / "reports" / name) as folder:
            _keep_files(root / "reports" / name, folder)
            files = _files(root, revision)
            stages = _copy_reports(files, root, name, folder)
            if any(params.get(key) != usual.get(key) for key in OF_PREDICTORS):
                _copy_predictors(files, name, folder / "predictors")
            command = ["dvc", "exp", "run", *flags(usual, params)]
            prints = {stage: read_contents(folder, stage).fingerprint for stage in stages}
            record = {
                "experiment": name,
                "commit": baseline,
                "command": shlex.join(command),
                "fingerprints": prints,
                "params": params,
            }
            write_json(folder / RECORD, record)
    except FileNotFoundError as error:
        problem = f"neither this machine nor a remote has {error.filename}; `dvc exp pull` may"
        raise InputError(f"experiment {name}", problem) from None


def _find_experiment(root: Path, name: str) -> tuple[str, str]:
    """The commit of the newest experiment of a name, and the commit it started from.

    Raises:
        InputError: there is none.
    """
    # refs/exps/<2 digits>/<38 digits of the commit it started from>/<name>
    words = ("--sort=-committerdate", "--format=%(objectname) %(refname)", "refs/exps/*/*/*")
    for line in git(root, "for-each-ref", *words).splitlines():
        revision, reference = line.split()
        _, _, start, rest, found = reference.split("/")
        if found == name:
            return revision, start + rest
    problem = "there is no such experiment; `dvc exp list --all-commits` names them"
    raise InputError("dvc", problem, field=name)


def has_experiment(root: Path, name: str, commit: str) -> bool:
    """Return whether an experiment of a name has been run from a commit."""
    reference = f"refs/exps/{commit[:2]}/{commit[2:]}/{name}"
    return git_if_known(root, "rev-parse", "--verify", "--quiet", reference) is not None


def _keep_files(former: Path, folder: Path) -> None:
    """Copy the files directly in a former folder; the experiment replaces its own among them."""
    for file in former.glob("*"):
        if file.is_file():
            shutil.copy(file, folder / file.name)


def _files(root: Path, revision: str) -> Any:
    """Return the files of a commit, those that DVC has among them."""
    from dvc.api import DVCFileSystem

    return DVCFileSystem(str(root), rev=revision)


def _copy_reports(files: Any, root: Path, name: str, folder: Path) -> list[str]:
    """Copy the report of every stage; return the stages."""
    stages = list(parse_yaml(files.read_text("dvc.yaml"))["stages"])
    _check_name(root, name, stages)
    stages = [one for one in stages if one != EXAM]
    for stage in stages:
        files.get(f"reports/{stage}", str(folder / stage), recursive=True)
    return stages


def _copy_predictors(files: Any, name: str, folder: Path) -> None:
    if files.exists(PREDICTORS):
        files.get(PREDICTORS, str(folder), recursive=True)
        _adapt_predictors(folder, f"reports/{name}")


def _check_name(root: Path, name: str, stages: Sequence[str]) -> None:
    """Refuse a name under which reports has, or will have, anything but a kept experiment."""
    path = root / "reports" / name
    if name in stages:
        problem = f"has the name of a stage, whose results are in reports/{name}; rename it"
        raise InputError(f"experiment {name}", problem)
    if path.exists() and not is_kept_run(path):
        problem = f"would take the place of reports/{name}, which is no kept experiment; rename it"
        raise InputError(f"experiment {name}", problem)


def _adapt_predictors(folder: Path, reports: str) -> None:
    """Remove predictors that are too large; let the cards of the others name ``reports``."""
    from rallygap.pipeline.predictors.storage import CARD, WEIGHTS

    for weights in list(folder.rglob(WEIGHTS)):
        if weights.stat().st_size > LARGEST_FILE:
            shutil.rmtree(weights.parent)
            warn(f"{weights.parent.name} is left out: its weights are too large for git")
    for card in folder.rglob(CARD):
        write_text(card, card.read_text(encoding="utf-8").replace("`reports/", f"`{reports}/"))


def _params_at(root: Path, revision: str) -> Any:
    return parse_yaml(git(root, "show", f"{revision}:params.yaml"))
