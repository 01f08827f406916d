"""The whole exam: ``make exam`` runs every question and writes the records and the costs.

That takes hours, so the stage hidden_effects reads the records and runs only a few questions again.
A killed run resumes, as long as nothing that its records depend on has changed. For development,
some of the questions can be run into another file; they resume in the same way::

    python -m pipeline.exam.full_run --groups distortion several --every 6 --out records.jsonl
"""

import argparse
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

SCRATCH = Path("scratch") / "exam"  # results of questions, in folders by fingerprint
# What records depend on: packages of ``models``, and the libraries.
DEPENDENCIES = ("models/arena", "models/ball", "models/exam", "models/gap", "constraints.txt")


def run_exam(root: Path) -> None:
    """Run the whole exam; write its records, and the costs of verdicts on this machine."""
    params = load_params(root / "params.yaml")
    results = run_questions(assignments(params), _scratch(root, params))
    write_records(root / RECORDS, [result.record for result in results])
    costs = root / "reports" / "costs"
    write_csv(costs / "verdicts.csv", verdict_costs(results), digits=3)
    write_json(costs / "verdicts.json", machine(root))
    shutil.rmtree(root / SCRATCH, ignore_errors=True)


def run_sample(root: Path, out: Path, groups: Sequence[str], every: int) -> None:
    """Run one question in so many of some groups, of all if none is given; write their records.

    Raises:
        InputError: there is no such group.
    """
    params = load_params(root / "params.yaml")
    asked = assignments(params)
    known = dict.fromkeys(question.group for question, _ in asked)
    for group in groups:
        if group not in known:
            raise InputError("--groups", f"there is no group {group!r}; groups: {', '.join(known)}")
    chosen = [one for one in asked if one[0].group in (groups or known)][::every]
    results = run_questions(chosen, _scratch(root, params))
    write_records(out, [result.record for result in results])


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


def _scratch(root: Path, params: Params) -> Path:
    return root / SCRATCH / short(fingerprint(root, params))


def _dependencies(root: Path) -> Iterator[Path]:
    for name in DEPENDENCIES:
        path = root / name
        yield from [path] if path.is_file() else sorted(path.rglob("*.py"))


def main() -> None:
    """Run the whole exam, or with ``--out`` a sample of it."""
    parser = argparse.ArgumentParser(description="run the exam, or a sample of it")
    parser.add_argument("--out", type=Path, help="file for the records of a sample")
    parser.add_argument("--groups", nargs="+", default=[], help="of the sample; default: all")
    parser.add_argument("--every", type=int, default=1, help="one question in so many")
    given = parser.parse_args()
    if given.every < 1:
        parser.error("--every: must be 1 or more")
    if given.out is not None:
        run_sample(repository_root(), given.out, given.groups, given.every)
    elif given.groups or given.every > 1:
        parser.error("a sample needs --out; reports/exam/records.jsonl is of the whole exam")
    else:
        run_exam(repository_root())


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        refuse(error)
