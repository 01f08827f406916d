"""A copy of the repository that runs undisturbed once, and is restored for every fault."""

import hashlib
import json
import re
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil
import yaml

from experiments.clone import ROOT, environment, small_clone
from rallygap.pipeline.params import read_yaml

OUTPUTS = ("artifacts", "reports")
CACHE = Path(".dvc") / "cache" / "files" / "md5"
STAGES = "rallygap.stages."  # modules of this package are stages
POLL = 0.02  # s
# DVC's own files, which it writes in place: a kill may damage them. What DVC then says.
REFUSALS = {
    "dvc.lock": r"'\S*dvc\.lock' (is invalid|validation failed)",
    "rwlock": r".*RWLock-file '\S*'(\. JSON structure is corrupted| format error)",
}


@dataclass(frozen=True)
class Ended:
    """How a command ended: its status, and what it printed."""

    status: int
    printed: str

    @property
    def message(self) -> str:
        """The line that says most: ours, an exception's or DVC's."""
        lines = [line.strip() for line in self.printed.splitlines()]
        for sought in (
            r"rallygap: (?!warning)",
            r"rallygap: ",
            r"\w*Error: ",
            r"ERROR: ",
            *REFUSALS.values(),
        ):
            matches = [line for line in lines if re.match(sought, line)]
            if matches:
                return matches[-1]
        return ""


@dataclass(frozen=True)
class Repository:
    """The copy, what an undisturbed run of it left, and how long its stages took."""

    folder: Path
    spare: Path  # the copy after the undisturbed run
    seconds: dict[str, float]  # by stage

    @contextmanager
    def without(self, stage: str) -> Iterator[None]:
        """As after the undisturbed run, but that ``stage`` has never run."""
        _copy(self.spare, self.folder)
        _forget(self.folder, stage)
        try:
            yield
        finally:
            settle(self.folder)

    def start(self, *command: str, **variables: str) -> "subprocess.Popen[bytes]":
        """Start a command in a process group of its own; what it prints goes to ``log``."""
        temporary = self.folder.with_name("tmp")
        temporary.mkdir(exist_ok=True)
        places = {
            "TMPDIR": str(temporary),
            "DVC_SITE_CACHE_DIR": str(self.folder.with_name("site_cache")),
        }
        self.log.unlink(missing_ok=True)  # what an earlier command still writes goes nowhere
        with self.log.open("wb") as log:
            return subprocess.Popen(
                command,
                cwd=self.folder,
                env={**environment(self.folder), **places, **variables},
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def reproduce(self, stage: str | None = None, **variables: str) -> Ended:
        """Run ``dvc repro``, of one stage and what it needs or of all."""
        command = ["dvc", "repro", *([stage] if stage else [])]
        status = self.start(*command, **variables).wait()
        return Ended(status, self.printed())

    @property
    def log(self) -> Path:
        """What the last command printed."""
        return self.folder.with_name("log")

    def printed(self) -> str:
        """What the last command printed, without the folders of this machine."""
        text = self.log.read_text(encoding="utf-8", errors="replace")
        return text.replace(f"{self.folder}/", "").replace(str(self.folder), ".")

    def recover(self) -> tuple[Ended, str]:
        """Run ``dvc repro``; where DVC refuses a file of its own, repair that and run it again.

        Returns how it ended, and the file that was repaired, as docs/reliability.md says; "" if
        none.
        """
        ended = self.reproduce()
        for name, refusal in REFUSALS.items():
            if re.search(refusal, ended.printed):
                self._repair(name)
                return self.reproduce(), name
        return ended, ""

    def _repair(self, name: str) -> None:
        if name == "rwlock":
            (self.folder / ".dvc" / "tmp" / name).unlink()
        else:
            subprocess.run(["git", "checkout", "--quiet", name], cwd=self.folder, check=True)

    def left_by(self, stage: str) -> list[str]:
        """The files among a stage's outputs, temporary ones too."""
        own = tuple(f"{name}/{stage}/" for name in OUTPUTS)
        return [path for path in digests(self.folder) if path.startswith(own)]

    def half_written(self) -> list[str]:
        """Outputs that stand under their name and are not those of the undisturbed run."""
        expected, outputs = digests(self.spare), digests(self.folder)
        shown = (path for path in outputs if not any(part[0] == "." for part in path.split("/")))
        return sorted(path for path in shown if outputs[path] != expected.get(path))

    def differences(self) -> list[str]:
        """Outputs that differ from the undisturbed run's, lack, or are too many; what DVC lost."""
        expected, outputs = digests(self.spare), digests(self.folder)
        paths = {
            path for path in expected.keys() | outputs if expected.get(path) != outputs.get(path)
        }
        entries = {entry for stage in stages() for entry in cached(self.spare, stage)}
        lost = {entry.as_posix() for entry in entries if not (self.folder / entry).exists()}
        return sorted(
            paths | lost | ({"dvc.lock"} if lock(self.spare) != lock(self.folder) else set())
        )


def undisturbed(folder: Path) -> Repository:
    """Copy the repository into ``folder``, with the smallest parameters, and run it undisturbed.

    It runs twice: what the first run compiles and keeps for later ones takes none of the stages'
    time in the second.
    """
    repository = Repository(folder / "repository", folder / "spare", {})
    small_clone(repository.folder)
    ended = repository.reproduce()
    assert ended.status == 0, ended.printed
    dvc = repository.start("dvc", "repro", "--force")
    while running := awaited_stage(dvc):
        stage, process = running
        started = time.monotonic()
        process.wait()
        repository.seconds[stage] = time.monotonic() - started
    assert dvc.wait() == 0, repository.printed()
    settle(repository.folder)
    subprocess.run(["git", "add", "--force", "dvc.lock"], cwd=repository.folder, check=True)
    _copy(repository.folder, repository.spare)
    return repository


def stages() -> list[str]:
    """The stages of the pipeline."""
    return list(read_yaml(ROOT / "dvc.yaml")["stages"])


def awaited_stage(dvc: "subprocess.Popen[bytes]") -> tuple[str, psutil.Process] | None:
    """Wait until a stage runs below DVC; return it and its process, None where DVC ends before."""
    below: list[psutil.Process] = []
    while dvc.poll() is None:
        with suppress(psutil.NoSuchProcess):
            below = psutil.Process(dvc.pid).children(recursive=True)
        for process in below:
            words = command_of(process)
            if words[1:2] == ["-m"] and words[2].startswith(STAGES):
                return words[2].removeprefix(STAGES), process
        time.sleep(POLL)
    return None


def command_of(process: psutil.Process) -> list[str]:
    """The words of a process's command; none where it has ended."""
    try:
        return process.cmdline()
    except psutil.Error:
        return []


def inhabitants(folder: Path) -> list[psutil.Process]:
    """The processes that work in a folder."""
    return [
        process
        for process in psutil.process_iter(["cwd"])
        if process.info["cwd"] and Path(process.info["cwd"]).is_relative_to(folder)
    ]


def settle(folder: Path) -> None:
    """Kill whatever is still at work in a folder."""
    processes = inhabitants(folder)
    for process in processes:
        with suppress(psutil.NoSuchProcess):  # it may end with the ones before it
            process.kill()
    psutil.wait_procs(processes)


def digests(folder: Path) -> dict[str, str]:
    """Path to SHA-256 of every file among the outputs, temporary ones too."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for name in OUTPUTS
        for path in (folder / name).rglob("*")
        if path.is_file()
    }


def cached(folder: Path, stage: str) -> set[Path]:
    """The files of DVC's cache that hold a stage's outputs, lists of folders among them.

    Returns:
        Paths below ``folder``; none for outputs that git keeps.
    """
    entries = set()
    for output in lock(folder)["stages"][stage]["outs"]:
        entry = _entry(output["md5"])
        if (folder / entry).exists():
            entries.add(entry)
        if (folder / entry).suffix == ".dir" and entry in entries:
            listed = json.loads((folder / entry).read_text())
            entries |= {_entry(part["md5"]) for part in listed}
    return entries


def _entry(digest: str) -> Path:
    return CACHE / digest[:2] / digest[2:]


def lock(folder: Path) -> Any:
    """What dvc.lock says, in whichever order."""
    return read_yaml(folder / "dvc.lock")


def _copy(source: Path, target: Path) -> None:
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(source, target, symlinks=True)


def _forget(folder: Path, stage: str) -> None:
    """Remove a stage's outputs and what DVC keeps of them, as if it had never run."""
    for name in OUTPUTS:
        shutil.rmtree(folder / name / stage, ignore_errors=True)
    shutil.rmtree(folder / ".dvc" / "cache" / "runs", ignore_errors=True)
    known = lock(folder)
    others = (cached(folder, other) for other in known["stages"] if other != stage)
    for entry in cached(folder, stage).difference(*others):
        (folder / entry).unlink()
    del known["stages"][stage]
    (folder / "dvc.lock").write_text(yaml.safe_dump(known, sort_keys=False))
