"""``python -m tests.fuzz``: put thousands of inputs before every reader and write the counts.

With the name of a reader, it alone is tried and nothing is written.
"""

import sys
from collections import Counter
from pathlib import Path

import pandas as pd

from pipeline.artifacts import replacing
from tests.fuzz.readers import READERS, Reader
from tests.fuzz.trial import tried

COUNTS = Path("reports") / "reliability" / "fuzz.csv"
EACH = 240  # inputs a reader


def counts(reader: Reader, count: int) -> dict[str, object]:
    """Return how often each outcome came, and print every fault."""
    outcomes: Counter[str] = Counter()
    for number, (outcome, said, content) in enumerate(tried(reader, count)):
        outcomes[outcome] += 1
        if outcome == "fault":
            sys.stdout.write(f"{reader.name}, input {number}: {said}\n  {content[:60]!r}\n")
    return {
        "reader": reader.name,
        "inputs": outcomes.total(),
        "refused": outcomes["refused"],
        "in_part": outcomes["in_part"],
        "accepted": outcomes["accepted"],
        "faults": outcomes["fault"],
    }


def main(names: list[str]) -> None:
    """Try every reader, or those named."""
    rows = []
    for reader in READERS:
        if not names or reader.name in names:
            rows.append(counts(reader, EACH))
            sys.stdout.write(f"{rows[-1]}\n")
            sys.stdout.flush()
    if not names:
        with replacing(COUNTS) as temporary:
            pd.DataFrame(rows).to_csv(temporary, index=False, lineterminator="\n")
    sys.exit(1 if any(row["faults"] for row in rows) else 0)


if __name__ == "__main__":
    main(sys.argv[1:])
