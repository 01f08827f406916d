"""A sample of the exam, for development: some of its questions into a file of their own.

For example::

    python -m experiments.exam_sample --groups distortion --every 6 --out records.jsonl
"""

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

from experiments.exam.records import write_records
from experiments.exam.whole import assignments, run_questions
from rallygap.pipeline.params import load_params
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import repository_root


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
    with tempfile.TemporaryDirectory(prefix="rallygap.") as folder:
        write_records(out, run_questions(chosen[::every], Path(folder)))


def main() -> None:
    """Run a sample of the exam."""
    parser = argparse.ArgumentParser(description="run some questions of the exam")
    parser.add_argument("--out", type=Path, required=True, help="file for the records")
    parser.add_argument("--groups", nargs="+", default=[], help="of questions; default: all")
    parser.add_argument("--every", type=int, default=1, help="one question in so many")
    given = parser.parse_args()
    if given.every < 1:
        parser.error("--every: must be 1 or more")
    run_sample(repository_root(), given.out, given.groups, given.every)


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        refuse(error)
