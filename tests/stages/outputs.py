"""The outputs of a stage, read back."""

import pandas as pd

from rallygap.pipeline.report.stages import PIPELINE, write_report


def table(run, name, *keys):
    """A table of the report, indexed by ``keys``; the report is written once, for its figures."""
    if not run.report(f"{name}.csv").exists():
        write_report(run, run.stage, PIPELINE[run.stage])
    rows = pd.read_csv(run.report(f"{name}.csv"))
    return rows.set_index(list(keys)) if keys else rows


def written(run):
    """The content of every file that a stage writes itself, by path."""
    files = [path for path in run.artifact(".").rglob("*") if path.is_file()]
    files.append(run.report("metrics.json"))
    return {str(path.relative_to(run.root)): path.read_bytes() for path in files}
