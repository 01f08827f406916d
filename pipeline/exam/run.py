"""The exam in full: ``make exam`` sits every question and keeps the sheets in the repository.

That takes hours, so the stage hidden_effects works on the sheets that it left, and sits a few
questions anew. A killed exam goes on where it was, as long as nothing changes what shapes its
sheets. How long verdicts took goes to ``reports/costs``, since times are never the same twice.
"""

import hashlib
import json
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd

from pipeline.evaluation.costs import machine
from pipeline.exam.records import SHEETS, Sat, seats, sit_all, write_sheets
from pipeline.io.artifacts import write_csv, write_json
from pipeline.io.simulators import load_simulator
from pipeline.params import Params, load_params
from pipeline.runtime.console import refuse
from pipeline.runtime.errors import InputError
from pipeline.runtime.paths import repository_root
from pipeline.runtime.provenance import short

# What decides about a sheet: the packages of ``models`` that it follows from, and the libraries.
SHAPING = ("models/arena", "models/ball", "models/exam", "models/gap", "constraints.txt")


def sit_exam(root: Path) -> None:
    """Sit the whole exam; write its sheets, and what verdicts cost on this machine."""
    params = load_params(root / "params.yaml")
    scratch = root / "scratch" / "exam"
    sat = sit_all(seats(params), scratch / short(fingerprint(root, params)))
    write_sheets(root / SHEETS, [one.sheet for one in sat])
    costs = root / "reports" / "costs"
    write_csv(costs / "verdicts.csv", verdict_costs(sat), digits=3)
    write_json(costs / "verdicts.json", machine(root))
    shutil.rmtree(scratch, ignore_errors=True)


def verdict_costs(sat: Sequence[Sat]) -> pd.DataFrame:
    """Return the CPU seconds of verdicts: one row a method and number of shots."""
    rows = [
        {"method": method, "shots": one.sheet.shots, "seconds": seconds}
        for one in sat
        for method, seconds in one.seconds.items()
    ]
    groups = pd.DataFrame(rows, columns=["method", "shots", "seconds"]).groupby(
        ["method", "shots"], sort=True
    )["seconds"]
    columns = {
        "verdicts": groups.size(),
        "cpu_s_median": groups.median(),
        "cpu_s_p95": groups.quantile(0.95),
        "cpu_s_total": groups.sum(),
    }
    return pd.DataFrame(columns).reset_index()


def fingerprint(root: Path, params: Params) -> str:
    """Return a digest of all that shapes the sheets."""
    digest = hashlib.sha256()
    settings = params.hidden_effects
    simulator = load_simulator(settings.simulator).to_dict()
    shaping = [params.seed, settings.peers_every, simulator]
    digest.update(json.dumps(shaping, sort_keys=True).encode())
    for path in _files(root):
        digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


def _files(root: Path) -> Iterator[Path]:
    for name in SHAPING:
        path = root / name
        yield from [path] if path.is_file() else sorted(path.rglob("*.py"))


if __name__ == "__main__":
    try:
        sit_exam(repository_root())
    except InputError as error:
        refuse(error)
