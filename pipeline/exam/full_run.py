"""The whole exam: ``make exam`` runs every question and writes the records and the costs.

That takes hours. A run that is stopped with Ctrl-C leaves the records that it has made in
``scratch/exam``, and the next run of the same code continues from them. For development, some of
the questions can be run into another file::

    python -m rallygap.pipeline.exam.full_run --groups distortion --every 6 --out records.jsonl
"""

import argparse
import shutil
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from rallygap.models.exam.records import ExamRecord
from rallygap.pipeline.evaluation.costs import machine
from rallygap.pipeline.exam.records import RECORDS, write_records
from rallygap.pipeline.exam.run import assignments, run_questions
from rallygap.pipeline.io.artifacts import write_csv, write_json
from rallygap.pipeline.params import load_params
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import repository_root
from rallygap.pipeline.runtime.provenance import combined_hash, short

SCRATCH = Path("scratch") / "exam"  # records of questions, in folders by what they depend on
INPUTS = ("params.yaml", *(f"models/{name}" for name in ("arena", "ball", "exam", "gap")))


def run_exam(root: Path) -> None:
    """Run all questions; write their records and the costs of verdicts."""
    records = run_questions(assignments(load_params(root / "params.yaml")), _scratch(root))
    write_records(root / RECORDS, records)
    costs = root / "reports" / "costs"
    write_csv(costs / "verdicts.csv", verdict_costs(records), digits=3)
    write_json(costs / "verdicts.json", machine(root))
    shutil.rmtree(root / SCRATCH, ignore_errors=True)


def run_sample(root: Path, out: Path, groups: Sequence[str], every: int) -> None:
    """Run one question in so many of some groups, of all if none is given; write their records.

    Raises:
        InputError: there is no such group.
    """
    asked = assignments(load_params(root / "params.yaml"))
    known = dict.fromkeys(question.group for question, _ in asked)
    for group in groups:
        if group not in known:
            raise InputError("--groups", f"there is no group {group!r}; groups: {', '.join(known)}")
    chosen = [
        (question, methods) for question, methods in asked if question.group in (groups or known)
    ]
    write_records(out, run_questions(chosen[::every], _scratch(root)))


def _scratch(root: Path) -> Path:
    return root / SCRATCH / short(combined_hash(root, INPUTS))


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
