"""How long `make reproduce` takes on a clean clone, and whether it leaves the committed bytes.

`python -m benchmarks.reproduce` clones the last commit, sets up an environment of its own there
and runs everything, stage by stage. Writes ``reports/costs/reproduce.csv`` and ``reproduce.json``.
Half an hour; give the machine nothing else to do meanwhile.
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

from pipeline.evaluation.costs import machine
from pipeline.io.artifacts import write_csv, write_json

ROOT = Path(__file__).parents[1]
MEASURED = ROOT / "reports" / "costs" / "reproduce.csv"
SET_UP = "set-up"
RUNNING = re.compile(r"Running stage '(\w+)'")


def cloned(folder: Path) -> Path:
    """Clone the last commit."""
    clone = folder / "clone"
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
    return clone


def reproduced(clone: Path) -> pd.DataFrame:
    """Run `make reproduce`; return what every part of it took (s), the set-up first.

    Raises:
        CalledProcessError: it failed.
    """
    begun = {SET_UP: time.monotonic()}
    # Environments of this process are not those of a fresh machine.
    own = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    with subprocess.Popen(
        ["make", "reproduce"], cwd=clone, env=own, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if found := RUNNING.search(line):
                begun[found[1]] = time.monotonic()
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, "make reproduce")
    moments = [*begun.values(), time.monotonic()]
    seconds = [after - before for before, after in pairwise(moments)]
    return pd.DataFrame({"part": list(begun), "seconds": seconds})


def changed(clone: Path) -> list[str]:
    """Return the committed files that are others now."""
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
