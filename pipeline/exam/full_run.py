"""The whole exam: ``make exam`` runs every question and writes the records and the costs.

That takes hours, so the stage hidden_effects reads the records and runs only a few questions again.
A killed run resumes, as long as nothing that its records depend on has changed.
"""

import hashlib
import json
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd

from pipeline.evaluation.costs import machine
from pipeline.exam.records import RECORDS, write_records
from pipeline.exam.run import Result, assignments, run_questions
from pipeline.io.artifacts import write_csv, write_json
from pipeline.io.simulators import load_simulator
from pipeline.params import Params, load_params
from pipeline.runtime.console import refuse
from pipeline.runtime.errors import InputError
from pipeline.runtime.paths import repository_root
from pipeline.runtime.provenance import short

# What records depend on: packages of ``models``, and the libraries.
DEPENDENCIES = ("models/arena", "models/ball", "models/exam", "models/gap", "constraints.txt")


def run_exam(root: Path) -> None:
    """Run the whole exam; write its records, and the costs of verdicts on this machine."""
    params = load_params(root / "params.yaml")
    scratch = root / "scratch" / "exam"
    results = run_questions(assignments(params), scratch / short(fingerprint(root, params)))
    write_records(root / RECORDS, [result.record for result in results])
    costs = root / "reports" / "costs"
    write_csv(costs / "verdicts.csv", verdict_costs(results), digits=3)
    write_json(costs / "verdicts.json", machine(root))
    shutil.rmtree(scratch, ignore_errors=True)


def verdict_costs(results: Sequence[Result]) -> pd.DataFrame:
    """Return the CPU seconds of verdicts: one row a method and number of shots."""
    rows = [
        {"method": method, "shots": result.record.shots, "seconds": seconds}
        for result in results
        for method, seconds in result.seconds.items()
    ]
    keys = ["method", "shots"]
    groups = pd.DataFrame(rows, columns=[*keys, "seconds"]).groupby(keys, sort=True)["seconds"]
    columns = {
        "verdicts": groups.size(),
        "cpu_s_median": groups.median(),
        "cpu_s_p95": groups.quantile(0.95),
        "cpu_s_total": groups.sum(),
    }
    return pd.DataFrame(columns).reset_index()


def fingerprint(root: Path, params: Params) -> str:
    """Return a digest of all that records depend on."""
    digest = hashlib.sha256()
    settings = params.hidden_effects
    simulator = load_simulator(settings.simulator).to_dict()
    values = [params.seed, settings.other_methods_every, simulator]
    digest.update(json.dumps(values, sort_keys=True).encode())
    for path in _dependencies(root):
        digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


def _dependencies(root: Path) -> Iterator[Path]:
    for name in DEPENDENCIES:
        path = root / name
        yield from [path] if path.is_file() else sorted(path.rglob("*.py"))


if __name__ == "__main__":
    try:
        run_exam(repository_root())
    except InputError as error:
        refuse(error)
