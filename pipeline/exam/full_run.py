"""The whole exam: ``make exam`` runs every question and writes the records and the costs.

That takes hours, so the stage hidden_effects reads the records and runs only a few questions again.
A run that is stopped with Ctrl-C leaves the records that it has made in a file of their own, and
the next run continues from it. Every record has a fingerprint of all that it depends on: records
with another fingerprint are made again, and no table mixes the two. For development, some of the
questions can be run into another file::

    python -m rallygap.pipeline.exam.full_run --groups distortion --every 6 --out records.jsonl
"""

import argparse
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd

from rallygap.models.exam.records import ExamRecord
from rallygap.pipeline.evaluation.costs import machine
from rallygap.pipeline.exam.records import RECORDS, UNFINISHED, read_records, write_records
from rallygap.pipeline.exam.run import (
    Assignment,
    assignments,
    code_of_records,
    finished,
    run_questions,
)
from rallygap.pipeline.io.artifacts import write_csv, write_json
from rallygap.pipeline.params import Params, load_params
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import repository_root

SCRATCH = Path("scratch") / "exam"  # results of questions, in folders by the code that made them


def run_exam(root: Path) -> None:
    """Run the questions without a record of this code; write records, and the costs of verdicts.

    A run that is stopped writes the unfinished records only, for the next run to continue from.
    """
    params = load_params(root / "params.yaml")
    asked, folder = assignments(params), _scratch(root, params)
    records = _kept_records(root, folder.name)
    pending = [one for one in asked if one[0].trial.name not in records]
    try:
        run_questions(pending, folder)
    finally:
        records |= {record.name: record for record in _made(pending, folder)}
        _write(root, asked, records)
    costs = root / "reports" / "costs"
    write_csv(costs / "verdicts.csv", verdict_costs(list(records.values())), digits=3)
    write_json(costs / "verdicts.json", machine(root))
    shutil.rmtree(root / SCRATCH, ignore_errors=True)


def _kept_records(root: Path, code: str) -> dict[str, ExamRecord]:
    """Return the records of this code by name."""
    files = (root / RECORDS, root / UNFINISHED)
    kept = [record for file in files if file.exists() for record in read_records(file)]
    return {record.name: record for record in kept if record.code == code}


def _write(root: Path, asked: Sequence[Assignment], records: dict[str, ExamRecord]) -> None:
    """Write all records, or those of an unfinished exam; they are in the order of the exam."""
    names = [question.trial.name for question, _ in asked]
    made = [records[name] for name in names if name in records]
    if len(made) == len(names):
        write_records(root / RECORDS, made)
        (root / UNFINISHED).unlink(missing_ok=True)
    elif made:
        write_records(root / UNFINISHED, made)


def _made(assignments: Sequence[Assignment], folder: Path) -> Iterator[ExamRecord]:
    """Yield the records of the questions that were asked, with their costs and their code."""
    for result in finished(assignments, folder):
        yield result.record.model_copy(update={"seconds": result.seconds, "code": folder.name})


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


def verdict_costs(records: Sequence[ExamRecord]) -> pd.DataFrame:
    """Return the CPU seconds of verdicts: one row a method and number of shots."""
    rows = [
        {"method": method, "shots": record.shots, "seconds": seconds}
        for record in records
        for method, seconds in record.seconds.items()
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


def _scratch(root: Path, params: Params) -> Path:
    return root / SCRATCH / code_of_records(root, params)


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
