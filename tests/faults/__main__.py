"""All kills and faults, an hour on two idle cores: ``python -m tests.faults``, as root.

Writes reports/reliability/kills.csv and faults.csv, row by row, so that what was done before an
interruption is there. Ends with status 1 where a run did not end as an undisturbed one.
"""

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd
from rich.console import Console
from rich.progress import Progress

from pipeline.artifacts import replacing
from tests.faults.breakages import FAULTS, Suffered, suffer
from tests.faults.disks import may_mount
from tests.faults.kills import Kill, kill_stage, kills_a_stage
from tests.faults.repository import ROOT, Repository, stages, undisturbed

REPORT = ROOT / "reports" / "reliability"


def main() -> None:
    """Run everything, write the tables, and say what failed."""
    if not may_mount():
        sys.exit("rallygap: faults of disks are mounted; run this as root")
    console = Console(stderr=True)
    with tempfile.TemporaryDirectory() as folder, Progress(console=console) as bar:
        task = bar.add_task("undisturbed", total=1 + len(stages()) * kills_a_stage() + len(FAULTS))
        repository = undisturbed(Path(folder))
        bar.advance(task)
        kills = _all_kills(repository, bar, task)
        faults = _all_faults(repository, bar, task)
    bad = [one for one in kills if not one.same_hashes]
    worse = [one for one in faults if not one.same_hashes or not one.as_expected]
    for one in [*bad, *worse]:
        console.print(one)
    sys.exit(1 if bad or worse else 0)


def _all_kills(repository: Repository, bar: Progress, task: Any) -> list[Kill]:
    kills: list[Kill] = []
    for stage in stages():
        for number in range(1, kills_a_stage() + 1):
            bar.update(task, description=f"kill {number} of {stage}")
            kills.extend(kill_stage(repository, stage, number, kills_a_stage()))
            _write("kills", kills)
            bar.advance(task)
    return kills


def _all_faults(repository: Repository, bar: Progress, task: Any) -> list[Suffered]:
    faults: list[Suffered] = []
    for fault in FAULTS:
        bar.update(task, description=fault.name)
        faults.append(suffer(repository, fault))
        _write("faults", faults)
        bar.advance(task)
    return faults


def _write(name: str, rows: Sequence[Any]) -> None:
    with replacing(REPORT / f"{name}.csv") as temporary:
        table = pd.DataFrame([asdict(row) for row in rows])
        table.to_csv(temporary, index=False, lineterminator="\n")


if __name__ == "__main__":
    main()
