"""Duration of `make reproduce` on a clean clone, and the committed files that it changes.

Clones the last commit, makes an environment there and runs all stages. Writes
``reports/costs/reproduce.csv`` and ``reproduce.json``. Up to an hour; run nothing else meanwhile.
"""

import os
import re
import subprocess
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import pandas as pd

from experiments.benchmarks.comparison import ROOT, write_measured

SET_UP = "set-up"
RUNNING = re.compile(r"Running stage '(\w+)'")


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
            if match := RUNNING.search(line):
                starts[match[1]] = time.monotonic()
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, "make reproduce")
    moments = [*starts.values(), time.monotonic()]
    seconds = [after - before for before, after in pairwise(moments)]
    return pd.DataFrame({"part": list(starts), "seconds": seconds})


def main() -> None:
    """Measure, write, print."""
    with tempfile.TemporaryDirectory() as folder:
        clone = Path(folder) / "clone"
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
        table = reproduced(clone)
        status = ["git", "status", "--porcelain"]
        listed = subprocess.run(status, cwd=clone, capture_output=True, text=True, check=True)
    seconds, changed = round(table["seconds"].sum()), listed.stdout.splitlines()
    write_measured("reproduce", table.round(), seconds=seconds, changed=changed)


if __name__ == "__main__":
    main()
