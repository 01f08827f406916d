"""Duration of `make reproduce` on a clean clone, and the committed files that it changes.

`python -m benchmarks.reproduce` clones the last commit, makes an environment there and runs all
stages. Writes ``reports/costs/reproduce.csv`` and ``reproduce.json``. Half an hour; run nothing
else meanwhile.
"""

import os
import re
import subprocess
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import pandas as pd
from rich.console import Console

from benchmarks.comparison import ROOT
from rallygap.pipeline.evaluation.costs import machine
from rallygap.pipeline.io.artifacts import write_csv, write_json

MEASURED = ROOT / "reports" / "costs" / "reproduce.csv"
SET_UP = "set-up"
RUNNING = re.compile(r"Running stage '(\w+)'")


def cloned(folder: Path) -> Path:
    """Clone the last commit."""
    clone = folder / "clone"
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
    return clone


def reproduced(clone: Path) -> pd.DataFrame:
    """Run `make reproduce`; return the seconds of the set-up and of every stage.

    Raises:
        CalledProcessError: it failed.
    """
    starts = {SET_UP: time.monotonic()}
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    with subprocess.Popen(
        ["make", "reproduce"], cwd=clone, env=environment, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if found := RUNNING.search(line):
                starts[found[1]] = time.monotonic()
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, "make reproduce")
    moments = [*starts.values(), time.monotonic()]
    seconds = [after - before for before, after in pairwise(moments)]
    return pd.DataFrame({"part": list(starts), "seconds": seconds})


def changed(clone: Path) -> list[str]:
    """Return the committed files that differ now."""
    status = ["git", "status", "--porcelain"]
    listed = subprocess.run(status, cwd=clone, capture_output=True, text=True, check=True)
    return listed.stdout.splitlines()


def main() -> None:
    """Measure, write, print."""
    with tempfile.TemporaryDirectory() as folder:
        clone = cloned(Path(folder))
        table = reproduced(clone)
        found = {
            **machine(clone),
            "seconds": round(table["seconds"].sum()),
            "changed": changed(clone),
        }
    write_csv(MEASURED, table.round())
    write_json(MEASURED.with_suffix(".json"), found)
    Console().print(MEASURED.read_text(), found)


if __name__ == "__main__":
    main()
