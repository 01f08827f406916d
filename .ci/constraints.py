"""Print the versions of a report of `pip install --dry-run --report` as constraints.

python .ci/constraints.py report.json > constraints.txt
"""

import json
import sys
from pathlib import Path

HEADER = """\
# Exact versions of everything that `make` installs. `make constraints` writes this file."""


def main() -> None:
    """Print them."""
    report = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    packages = [entry["metadata"] for entry in report["install"]]
    print(HEADER)
    for package in sorted(packages, key=lambda package: package["name"].lower()):
        if package["name"] != "rallygap":
            print(f"{package['name']}=={package['version'].partition('+')[0]}")


if __name__ == "__main__":
    main()
