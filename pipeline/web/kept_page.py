"""Report pages of kept runs, which are built and not committed."""

from pathlib import Path

from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.io.report_manifest import read_contents
from rallygap.pipeline.paper.run_reports import RECORD, is_kept_run, kept_reports
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.web.report_page import render_page


def kept_runs(root: Path) -> list[str]:
    """Return the names of the kept runs in ``reports``."""
    return [one.name for one in sorted((root / "reports").glob("*")) if is_kept_run(one)]


def kept_page(root: Path, name: str) -> str:
    """Render the figures and tables of a kept run; it has no recordings for 3-D views.

    Raises:
        InputError: there is no such run, or a file of it is missing or broken.
    """
    folder = root / "reports" / name
    if name not in kept_runs(root):
        known = ", ".join(kept_runs(root)) or "none"
        raise InputError(folder, f"is not a kept run; there are: {known}")
    stages = read_json(folder / RECORD)["fingerprints"]
    contents = [one for one in (read_contents(folder, stage) for stage in stages) if one.items]
    return render_page(kept_reports(folder), contents, shots=[], returns=[])
